// When which frame of a film is shown. Times are frames: 0 is the start, frame t of the script ends
// at time t. Clocks are seconds at speed 1: frames last differently long, and the ends of some are
// held.
export const makeClock = (film) => {
  const T = film.last;
  const begins = [0]; // the clock at which each frame begins
  film.seconds.forEach((lasts, k) => begins.push(begins[k] + lasts + film.rests[k]));

  // Who goes on from the end of a frame need not wait for its rest.
  function clockAt(time) {
    const k = Math.min(Math.floor(time), T - 1);
    return begins[k] + (time - k) * film.seconds[k];
  }

  function timeAt(clock) {
    let [low, high] = [0, T]; // the last frame that has begun: begins[low] <= clock < begins[high]
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (begins[middle] <= clock) low = middle;
      else high = middle;
    }
    return Math.min(low + (clock - begins[low]) / film.seconds[low], low + 1);
  }

  return { clockAt, timeAt };
};
