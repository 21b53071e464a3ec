// A small picture of what the stage shows, for the gallery; kept in this browser.

const WIDTH = 360; // pixels
const BEFORE = "i2p-picture:";

/** Keeps the drawing of a film as the picture of a file. */
export async function keepPicture(place, svg) {
  const { width, height } = svg.viewBox.baseVal;
  const size = [WIDTH, Math.round((WIDTH * height) / width)];
  const copy = svg.cloneNode(true);
  for (const layer of copy.querySelectorAll(".hands")) layer.remove();
  copy.setAttribute("width", size[0]);
  copy.setAttribute("height", size[1]);
  const text = new XMLSerializer().serializeToString(copy);
  const image = new Image(...size);
  image.src = URL.createObjectURL(new Blob([text], { type: "image/svg+xml" }));
  try {
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = size;
    canvas.getContext("2d").drawImage(image, 0, 0, ...size);
    localStorage.setItem(BEFORE + place, canvas.toDataURL("image/webp", 0.8));
  } catch {
    // A picture less: what is typed has the room.
  } finally {
    URL.revokeObjectURL(image.src);
  }
}

export const pictureOf = (place) => localStorage.getItem(BEFORE + place);
