// Leads a participant through a study: consent, instructions, practice, films, and the answers as a
// CSV file. Before it come settings.js (what researchers change), study.js (what is asked, and the
// lists of films that participants are dealt), and stage.js, which defines makeStage and makeClock.
(() => {
  "use strict";

  const $ = (id) => document.getElementById(id);
  const { STUDY: study, SETTINGS: settings } = window;

  function complain(text) {
    $("trouble").textContent = text;
    $("trouble").hidden = false;
  }

  if (!study || !settings) {
    complain(
      study
        ? "settings.js is missing or cannot be read: is there a ` or a comma too many or too few?"
        : "study.js is missing: all files of the folder belong together.",
    );
    return;
  }
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const CHECK = -1; // in a list: the practice film, below which something else is asked
  const FAR = 90; // of 100: who moves the slider so far has moved it to its end

  // ------------------------------------------------------------------ who, and what is kept

  const given = new URLSearchParams(location.search);
  const KEPT = `i2p-study ${study.id}`;

  // Letters, digits, points and dashes: whatever reads the table takes nothing else out of it.
  const cleaned = (name) => name.replace(/[^\w.-]/g, "").replace(/^[.-]+/, "").slice(0, 64);

  function drawnName() {
    const bytes = crypto.getRandomValues(new Uint8Array(6));
    return `p${[...bytes].map((byte) => byte.toString(36).padStart(2, "0")).join("")}`;
  }

  const store = {
    get(key) {
      try {
        return localStorage.getItem(key);
      } catch {
        return null;
      }
    },
    set(key, value) {
      try {
        if (value === null) localStorage.removeItem(key);
        else localStorage.setItem(key, value);
      } catch {
        complain("This browser does not keep your answers: please do not reload or close the page.");
      }
    },
  };

  function hash(text) {
    let h = 2166136261; // FNV-1a
    for (const letter of text) h = Math.imul(h ^ letter.codePointAt(0), 16777619) >>> 0;
    return h;
  }

  function begun() {
    const names = ["PROLIFIC_PID", "participant", "workerId"];
    const said = names.map((name) => cleaned(given.get(name) ?? "")).find(Boolean);
    const participant = said ?? store.get(KEPT) ?? drawnName();
    if (!said) store.set(KEPT, participant);
    try {
      const kept = JSON.parse(store.get(`${KEPT} ${participant}`));
      if (kept) return kept;
    } catch {
      // Something else has written there.
    }
    // The same participant is dealt the same films on any device.
    const asked = /^\d{1,6}$/.test(given.get("list") ?? "") ? Number(given.get("list")) : null;
    const list = (asked ?? hash(participant)) % study.lists.length;
    const started = new Date().toISOString();
    return { participant, list, started, page: "consent", answers: [], sent: false };
  }

  const state = begun();
  const dealt = study.lists[state.list].map((number) => ({
    isCheck: number === CHECK,
    films: number === CHECK ? study.practice : study.items[number],
  }));

  function keep(change) {
    Object.assign(state, change);
    store.set(`${KEPT} ${state.participant}`, JSON.stringify(state));
  }

  // ------------------------------------------------------------------ films

  const films = {};
  const awaited = {};
  window.FILM = (name, film) => {
    films[name] = film;
  };

  function load(name) {
    awaited[name] ??= new Promise((resolve, reject) => {
      const script = document.createElement("script");
      script.src = `films/${name}.js`;
      script.onload = () => (films[name] ? resolve(films[name]) : reject(new Error(name)));
      script.onerror = () => {
        delete awaited[name]; // it may come when asked again
        script.remove();
        reject(new Error(name));
      };
      document.head.append(script);
    });
    return awaited[name];
  }

  // Of several films all that one page draws: lists that each film has one entry of are joined.
  function together(shown) {
    const joined = { ...shown[0].data };
    for (const key of ["shows", "performances"]) {
      if (joined[key]) joined[key] = shown.flatMap((film) => film.data[key]);
    }
    return joined;
  }

  let player = null;

  function makePlayer(shown, onEnd) {
    const longest = shown.reduce((a, b) => (b.seconds.length > a.seconds.length ? b : a));
    const last = longest.seconds.length;
    const stage = makeStage(together(shown));
    const clock = makeClock({ ...longest, last, rests: longest.seconds.map(() => 0) });
    const whole = longest.seconds.reduce((a, b) => a + b, 0);
    let [passed, before, playing, plays] = [0, 0, false, 0]; // seconds; the browser's milliseconds
    const self = { play, pause, isPlaying: () => playing, plays: () => plays };

    function draw() {
      stage.draw(last ? clock.timeAt(Math.min(passed, whole)) : 0);
      $("played").style.width = `${(100 * passed) / Math.max(whole, 1e-9)}%`;
      $("play").textContent = playing ? "Pause" : plays ? "Replay" : "Play";
    }

    function advance(now) {
      if (!playing || player !== self) return;
      passed += Math.min(Math.max(now - before, 0), 100) / 1000; // who looked away misses nothing
      before = now;
      if (passed >= whole) {
        passed = whole;
        playing = false;
        plays += 1;
        onEnd();
      } else requestAnimationFrame(advance);
      draw();
    }

    function play() {
      if (playing) return;
      if (passed >= whole) passed = 0;
      playing = true;
      $("caption").textContent = "";
      before = performance.now();
      draw();
      requestAnimationFrame(advance);
    }

    function pause() {
      playing = false;
      draw();
    }

    draw();
    return self;
  }

  // ------------------------------------------------------------------ one film and its question

  let item = null; // what is shown: {films, isCheck}
  let began = 0; // when, by the browser's clock
  let readWords = false;

  const LETTERS = ["A", "B"];
  const noun = study.answers.kind === "pair" ? "films" : "film";
  const options = {
    choice: () => study.answers.options,
    pair: () => ["first", "second"].map((value, i) => ({ value, label: `Film ${LETTERS[i]}` })),
  }[study.answers.kind]?.();

  function drawOptions() {
    $("options").replaceChildren();
    if (options) {
      for (const { value, label } of options) {
        const line = document.createElement("label");
        const [button, text] = [document.createElement("input"), document.createElement("span")];
        Object.assign(button, { type: "radio", name: "answer", value });
        text.textContent = label;
        line.append(button, text);
        $("options").append(line);
      }
      return;
    }
    const [slider, ends] = [document.createElement("input"), document.createElement("p")];
    Object.assign(slider, { type: "range", id: "slider", min: 0, max: 100, value: 50 });
    slider.className = "untouched"; // without a thumb, which would suggest an answer
    slider.setAttribute("aria-labelledby", "question");
    slider.setAttribute("aria-valuetext", "not answered yet");
    slider.setAttribute("aria-describedby", "ends");
    const touch = () => {
      slider.classList.remove("untouched");
      slider.style.setProperty("--done", `${slider.value}%`);
      slider.setAttribute("aria-valuetext", `${slider.value} of 100`);
    };
    slider.addEventListener("pointerdown", touch);
    slider.addEventListener("input", touch);
    slider.addEventListener("keydown", (event) => {
      if (event.key === " " || event.key.startsWith("Arrow")) touch();
    });
    Object.assign(ends, { id: "ends", className: "ends" });
    for (const text of [study.answers.low, study.answers.high]) {
      const end = document.createElement("span");
      end.textContent = text;
      ends.append(end);
    }
    $("options").classList.add("slider");
    $("options").append(slider, ends);
  }

  function answered() {
    if (!options) return $("slider").classList.contains("untouched") ? null : $("slider").value;
    return document.querySelector("#options :checked")?.value ?? null;
  }

  function tellWords(shown) {
    const told = shown.flatMap((film, place) =>
      film.told.map((text) => (shown.length > 1 ? `Film ${LETTERS[place]}: ${text}` : text)),
    );
    $("in-words").hidden = told.length === 0;
    $("in-words").open = false;
    const lines = told.map((text) => {
      const line = document.createElement("li");
      line.textContent = text;
      return line;
    });
    $("told").start = 0;
    $("told").replaceChildren(...lines);
  }

  async function showFilm(next, name) {
    item = next;
    player = null;
    readWords = false;
    show("trial");
    $("trial-name").textContent = name;
    $("trial-hint").textContent = `Watch the ${noun} to the end, then answer.`;
    $("question").textContent = next.isCheck ? study.check.question : study.question;
    $("answers").disabled = true;
    $("next").disabled = true;
    $("play").hidden = true;
    $("missing").textContent = "";
    $("caption").textContent = "Loading …";
    $("theatre").replaceChildren();
    drawOptions();
    let shown;
    try {
      shown = await Promise.all(next.films.map(load));
    } catch {
      if (item === next) {
        $("caption").textContent = "The film did not come. ";
        $("play").textContent = "Try again";
        $("play").hidden = false;
      }
      return;
    }
    if (item !== next) return;
    const parts = shown.map((film, place) => {
      const part = document.createElement("div");
      part.className = "film";
      part.style.setProperty("--aspect", film.aspect);
      part.innerHTML = film.stages[place]; // of our own file
      if (shown.length > 1) {
        const label = document.createElement("p");
        label.textContent = `Film ${LETTERS[place]}`;
        part.prepend(label);
        part.querySelector("svg").setAttribute("aria-label", label.textContent);
      }
      return part;
    });
    $("theatre").replaceChildren(...parts);
    tellWords(shown);
    began = performance.now();
    player = makePlayer(shown, () => {
      $("answers").disabled = false;
      $("next").disabled = false;
      $("caption").textContent = "You can answer now, or watch again first.";
    });
    $("play").hidden = false;
    $("caption").textContent = calm.matches ? "Press “Play” to watch." : "";
    const mine = player;
    if (!calm.matches) setTimeout(() => player === mine && !mine.plays() && mine.play(), 700);
  }

  $("play").addEventListener("click", () => {
    if (!player) showFilm(item, $("trial-name").textContent);
    else if (player.isPlaying()) player.pause();
    else player.play();
  });
  $("in-words").addEventListener("toggle", () => {
    readWords ||= $("in-words").open;
  });

  // ------------------------------------------------------------------ the table

  const isPassed = (answer) => {
    if (options) return answer === study.check.answer;
    return study.check.answer === "high" ? answer >= FAR : answer <= 100 - FAR;
  };

  function table(isComplete) {
    const checks = state.answers.filter(({ at }) => dealt[at].isCheck);
    const attention = checks.length === 0 ? "" : checks.every(({ answer }) => isPassed(answer));
    const rows = state.answers
      .filter(({ at }) => !dealt[at].isCheck)
      .map((given, number) => ({
        participant: state.participant,
        script: `scripts/${dealt[given.at].films[0]}.json`,
        frame: "T",
        question: study.name,
        answer: given.answer,
        ...(dealt[given.at].films[1] && { other: `scripts/${dealt[given.at].films[1]}.json` }),
        study: study.id,
        list: state.list,
        order: number + 1,
        plays: given.plays,
        seconds: given.seconds,
        words: given.words ? "read" : "",
        attention: attention === "" ? "" : attention ? "passed" : "failed",
        complete: isComplete ? "yes" : "no",
        started: state.started,
        window: state.window,
      }));
    const quoted = (cell) => (/[",\r\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);
    const lines = [Object.keys(rows[0] ?? {}), ...rows.map(Object.values)];
    return `${lines.map((cells) => cells.map((c) => quoted(String(c))).join(",")).join("\n")}\n`;
  }

  const isComplete = () => state.answers.length === dealt.length;

  function download() {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([table(isComplete())], { type: "text/csv" }));
    link.download = `${study.id}-${state.participant}.csv`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  }

  async function send() {
    $("send").hidden = true;
    $("sent").textContent = "Sending your answers …";
    try {
      // As plain text, so that a server on another host is not asked first.
      const reply = await fetch(settings.post, {
        method: "POST",
        body: table(isComplete()),
        headers: { "Content-Type": "text/plain;charset=UTF-8" },
        signal: AbortSignal.timeout?.(20000),
      });
      if (!reply.ok) throw new Error(reply.status);
      keep({ sent: true });
    } catch {
      $("send").hidden = false;
    }
    showSent();
  }

  function showSent() {
    const send = "Your answers have been sent.";
    const failed = "Your answers could not be sent. Please try again, or download them and hand the file to the researchers.";
    const none = "Please download your answers and hand the file to the researchers.";
    $("sent").textContent = state.sent ? send : settings.post ? failed : none;
    $("download").classList.toggle("main", !state.sent);
  }

  // ------------------------------------------------------------------ pages

  const PAGES = [...document.querySelectorAll("main > section")];

  function show(name) {
    for (const page of PAGES) page.hidden = page.id !== name;
    const done = state.page === "done" ? dealt.length : state.answers.length;
    $("way").hidden = !["trial", "done", "stopped"].includes(name) || state.page === "practice";
    $("way").firstChild.style.width = `${(100 * done) / dealt.length}%`;
    scrollTo(0, 0);
    document.querySelector(`#${name} h1`).focus({ preventScroll: true });
  }

  const enter = {
    consent: () => show("consent"),
    instructions: () => show("instructions"),
    practice: () => showFilm({ films: study.practice, isCheck: false }, "Practice"),
    feedback() {
      const chosen = options?.find(({ value }) => value === state.practised)?.label;
      const answer = chosen ? `You answered: “${chosen}”.` : `You put the slider at ${state.practised} of 100.`;
      write("feedback-text", `${answer} ${study.feedback}`);
      show("feedback");
    },
    trial() {
      if (isComplete()) return go("done");
      const next = dealt[state.answers.length];
      showFilm(next, `${noun === "films" ? "Pair" : "Film"} ${state.answers.length + 1} of ${dealt.length}`);
      for (const name of dealt[state.answers.length + 1]?.films ?? []) load(name).catch(() => {});
    },
    stopped() {
      item = player = null;
      $("stopped-text").textContent = `You answered ${state.answers.length} of ${dealt.length}. You can hand over what you have answered so far, or erase it.`;
      $("hand-over").hidden = state.answers.length === 0;
      show("stopped");
    },
    done() {
      item = player = null;
      const all = isComplete();
      $("done-name").textContent = all ? "Thank you!" : "Thank you for your answers so far";
      $("done-text").textContent = all ? "You have seen all films." : "";
      $("code").hidden = !(all && settings.completionCode);
      $("code-text").textContent = settings.completionCode;
      $("onward").hidden = !(all && settings.completionUrl);
      show("done");
      showSent();
      if (settings.post && !state.sent) send();
    },
  };

  function go(page) {
    keep({ page });
    enter[page]();
  }

  // Paragraphs; what is still to be filled in is marked.
  function write(id, text) {
    const paragraphs = text.trim().split(/\n\s*\n/).filter(Boolean).map((content) => {
      const paragraph = document.createElement("p");
      content.split(/(\[\[.*?\]\])/s).forEach((piece) => {
        const node = document.createElement(piece.startsWith("[[") ? "mark" : "span");
        node.textContent = piece;
        paragraph.append(node);
      });
      return paragraph;
    });
    $(id).replaceChildren(...paragraphs);
  }

  function submits(page, then) {
    document.querySelector(`#${page} form`).addEventListener("submit", (event) => {
      event.preventDefault();
      then();
    });
  }

  submits("consent", () => {
    keep({ window: `${innerWidth}x${innerHeight}` });
    go("instructions");
  });
  submits("instructions", () => go("practice"));
  submits("feedback", () => go("trial"));
  submits("trial", () => {
    const answer = answered();
    if (answer === null) {
      $("missing").textContent = options ? "Please choose an answer." : "Please move the slider.";
      (options ? document.querySelector("#options input") : $("slider")).focus();
      return;
    }
    if (state.page === "practice") {
      keep({ practised: answer });
      return go("feedback");
    }
    const seconds = Math.round((performance.now() - began) / 100) / 10;
    const given = { at: state.answers.length, answer, plays: player.plays(), seconds, words: readWords };
    keep({ answers: [...state.answers, given] });
    enter.trial();
  });
  $("again").addEventListener("click", () => go("practice"));
  $("stop").addEventListener("click", () => go("stopped"));
  $("resume").addEventListener("click", () => go(state.practised ? "trial" : "practice"));
  $("hand-over").addEventListener("click", () => go("done"));
  $("erase").addEventListener("click", () => {
    for (const key of [`${KEPT} ${state.participant}`, KEPT]) store.set(key, null);
    show("erased");
  });
  $("send").addEventListener("click", send);
  $("download").addEventListener("click", download);
  $("onward").addEventListener("click", () => location.assign(settings.completionUrl));

  $("agreement").textContent = settings.agreement;
  write("consent-text", settings.consent);
  $("unfilled").hidden = !settings.consent.includes("[[");
  write("instructions-text", `${study.instructions}\n\n${settings.instructions ?? ""}`);
  enter[state.page]();
})();
