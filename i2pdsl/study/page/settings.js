// What you change of this study. `i2p study --kit` writes this file once and never again.
// Texts stand between two ` marks; an empty line begins a new paragraph.
window.SETTINGS = {
  // What participants agree to before anything else. Fill in what stands in [[ ]].
  consent: `
You are invited to take part in a study by [[your names and your institution]]. It is about how people understand short animated films, and it takes about $minutes minutes.

You will watch short films and say after each one how it looked to you. There are no right or wrong answers. Nothing in the films is violent or frightening, and none of them flashes.

Taking part is voluntary. You can stop at any time, without a reason and without disadvantage: press “Stop here” below any film. [[What participants are paid, and when.]]

We keep your answers, how long each one took, how often you watched each film, the size of your window and the participant number that you came with. We do not keep your name or your address on the internet. [[Where the data are kept, for how long, and who can see them. The approval of your ethics board.]]

Questions: [[a name and an address]].
`,
  agreement: "I am at least 18 years old, I have read this, and I want to take part.",

  // More for the page of instructions, after what stands there anyway; may be empty.
  instructions: ``,

  // Where the answers are posted to as CSV, such as "https://example.org/answers"; empty: nowhere.
  // If that does not work, the participant is asked to download the file, as without it.
  post: "",

  // What the participant is shown or sent to in the end; may be empty.
  completionCode: "",
  completionUrl: "",
};
