// How much two pictures of the same canvas differ. They are read by the browser, which knows PNG.

/** The share of pixels of which some channel differs by more than a sixteenth. */
export async function differing(page, before, after) {
  return page.evaluate(async ([first, second]) => {
    const pixels = async (base64) => {
      const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
      const canvas = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
      canvas.drawImage(bitmap, 0, 0);
      return canvas.getImageData(0, 0, bitmap.width, bitmap.height).data;
    };
    const [a, b] = [await pixels(first), await pixels(second)];
    if (a.length !== b.length) return 1;
    let differ = 0;
    for (let i = 0; i < a.length; i += 4) {
      differ += [0, 1, 2].some((channel) => Math.abs(a[i + channel] - b[i + channel]) > 16) ? 1 : 0;
    }
    return (4 * differ) / a.length;
  }, [before.toString('base64'), after.toString('base64')]);
}
