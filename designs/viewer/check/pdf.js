// On which page of a PDF a link lies: enough of the format for what Chromium writes, whose dictionaries are plain text.

/** Pages by the link's address, each as often as it lies there. */
export function linksOf(pdf) {
  const text = pdf.toString('latin1');
  const objects = new Map();
  for (const [, number, body] of text.matchAll(/(?:^|\n)(\d+) 0 obj\s([\s\S]*?)\nendobj/g)) objects.set(number, body);
  const pages = pagesOf(objects);
  const found = new Map();
  pages.forEach((page, number) => {
    const annotations = /\/Annots \[([\s\S]*?)\]\n?/.exec(page)?.[1] ?? '';
    const inline = [annotations, ...[...annotations.matchAll(/(\d+) 0 R/g)].map(([, id]) => objects.get(id) ?? '')];
    for (const [, address] of inline.join('\n').matchAll(/\/URI \(([^)]*)\)/g)) {
      found.set(address, [...(found.get(address) ?? []), number + 1]);
    }
  });
  return { pages: pages.length, links: found };
}

/** Page objects in their order, from the tree that the catalogue names. */
function pagesOf(objects) {
  const catalogue = [...objects.values()].find((body) => /\/Type \/Catalog/.test(body));
  const walk = (number) => {
    const body = objects.get(number);
    if (!/\/Type \/Pages/.test(body)) return [body];
    const kids = /\/Kids \[([\s\S]*?)\]/.exec(body)[1];
    return [...kids.matchAll(/(\d+) 0 R/g)].flatMap(([, kid]) => walk(kid));
  };
  return walk(/\/Pages (\d+) 0 R/.exec(catalogue)[1]);
}
