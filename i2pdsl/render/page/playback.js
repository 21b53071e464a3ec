// The time of a film: plays, rests, and goes where it is told. Times are frames, as in clock.js.
import { makeClock } from "./clock.js";

export const SPEEDS = [0.5, 1, 2, 4];
export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

// `draw(time)` is called for each picture, `changed(playing)` when it begins or ends to play, and
// `rested()` when somebody, or its end, has brought it to rest.
export const makePlayback = (film, { draw, changed = () => {}, rested = () => {} }) => {
  const T = film.last;
  const { clockAt, timeAt } = makeClock(film);
  let time = 0;
  let speed = 1;
  let playing = false;
  let clock = 0; // while it plays
  let before = 0; // the browser's clock at the last picture, in milliseconds

  function setPlaying(on) {
    playing = on;
    changed(on);
  }

  function seek(t) {
    pause();
    time = clamp(t, 0, T);
    draw(time);
    rested();
  }

  const step = (by) => seek(by > 0 ? Math.floor(time + 1e-6) + by : Math.ceil(time - 1e-6) + by);

  function advance(now) {
    if (!playing) return;
    const passed = clamp(now - before, 0, 100); // a tab that slept goes on where it was
    before = now;
    clock += (passed / 1000) * speed;
    time = timeAt(clock);
    draw(time);
    if (time < T) requestAnimationFrame(advance);
    else {
      pause();
      rested();
    }
  }

  function play() {
    if (playing || T === 0) return;
    if (time >= T) time = 0;
    setPlaying(true);
    clock = clockAt(time);
    before = performance.now();
    requestAnimationFrame(advance);
  }

  function pause() {
    if (playing) setPlaying(false);
  }

  function toggle() {
    if (!playing) return play();
    pause();
    rested();
  }

  return {
    seek,
    step,
    play,
    pause,
    toggle,
    setSpeed: (to) => (speed = to),
    get time() {
      return time;
    },
    get speed() {
      return speed;
    },
    get isPlaying() {
      return playing;
    },
  };
};
