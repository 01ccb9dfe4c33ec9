/* Opened: the last of a page's scripts. Opens it, and tells where nothing can be drawn. */

function cube({ min, max }) {
  return Array.from({ length: 8 }, (_, k) => new THREE.Vector3(k & 1 ? min.x : max.x, k & 2 ? min.y : max.y, k & 4 ? min.z : max.z));
}

/** The object and its own drawings in view, and the hand where that leaves them large enough. */
function fit({ view, solids }, own) {
  view.scene.updateMatrixWorld(true);
  const corners = (things) => things.flatMap((thing) => {
    const box = new THREE.Box3().setFromObject(thing);
    return box.isEmpty() ? [] : cube(box);
  });
  const { object, ...others } = solids.layers;
  view.frame(corners([...object, ...own]), corners(Object.values(others).flat()));
}

/** Count colours on the canvas, for tests; a blank one is told. Must follow a drawing at once. */
function examine(renderer) {
  const gl = renderer.getContext(), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight, pixels = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const colours = new Map();
  for (let i = 0; i < pixels.length; i += 4) {
    if (!pixels[i + 3]) continue;
    const key = (pixels[i] >> 4 << 8) | (pixels[i + 1] >> 4 << 4) | (pixels[i + 2] >> 4);
    colours.set(key, (colours.get(key) || 0) + 1);
  }
  let painted = 0;
  for (const count of colours.values()) painted += count;
  const told = document.documentElement.dataset;
  told.triangles = renderer.info.render.triangles;
  told.colours = colours.size;
  told.painted = (painted / (w * h || 1)).toFixed(4);
  if (!colours.size) say("This browser draws nothing in three dimensions. What stands beside the picture is complete.");
}

function say(text) {
  const notice = document.getElementById("notice");
  notice.textContent = text;
  notice.hidden = false;
}

open().catch((error) => {
  document.documentElement.dataset.error = String(error);
  say(`The picture cannot be drawn in this browser (${error.message}). What stands beside it is complete.`);
});
