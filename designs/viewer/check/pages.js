// Opens the pages of `fabkit guide` in Chromium, from disk and offline, and tries what a reader would:
//
//     node check/pages.js CHROMIUM FOLDER...
//
// Each folder holds `index.html` and `guide.json`. Exits with 1 and says what does not hold.

import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import validator from 'gltf-validator';
import { chromium } from 'playwright-core';
import { linksOf } from './pdf.js';
import { differing } from './picture.js';

const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
// On a quiet machine; whoever knows that it is not says how long it may take.
const FIRST_FRAME_MS = Number(process.env.FABKIT_FIRST_FRAME_MS ?? 1000);
const NARROW = { width: 400, height: 800 };
const WIDE = { width: 1100, height: 900 };
// What is never cut by the edge of paper, unless it is longer than a page.
const WHOLE = 'tbody tr, .step, figure, svg';
const PAPER = { A4: 297, Letter: 279.4 };

const [, , program, ...folders] = process.argv;
const faults = [];
const browser = await chromium.launch({
  executablePath: program,
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
for (const folder of folders) await pageOf(folder);
await browser.close();
for (const fault of faults) console.error(`FAULT ${fault}`);
process.exit(faults.length === 0 ? 0 : 1);

async function pageOf(folder) {
  const address = pathToFileURL(resolve(folder, 'index.html')).href;
  const guide = JSON.parse(readFileSync(join(folder, 'guide.json'), 'utf8'));
  const fault = (text) => faults.push(`${folder}: ${text}`);
  const began = Date.now();
  const visit = async (options, look) => {
    const context = await browser.newContext({ offline: true, viewport: WIDE, reducedMotion: 'reduce', ...options });
    const page = await context.newPage();
    page.on('console', (message) => fault(`console: ${message.text()}`));
    page.on('pageerror', (error) => fault(`error: ${error.message}`));
    page.on('request', (request) => request.url() === address || fault(`request: ${request.url().slice(0, 200)}`));
    await page.goto(address);
    await page.waitForTimeout(100);
    await look(page);
    await context.close();
  };
  const told = {};
  await visit({}, async (page) => {
    await viewer(page, guide, fault, told);
    await accessible(page, 'wide', fault);
  });
  await visit({ colorScheme: 'dark' }, async (page) => {
    const paper = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    if (paper.match(/\d+/g).some((part) => Number(part) > 80)) fault(`dark: the paper is ${paper}`);
    await accessible(page, 'dark', fault);
  });
  await visit({ viewport: NARROW, hasTouch: true }, async (page) => {
    await narrow(page, 'narrow', fault);
    if (!(await page.locator('.viewer canvas').isVisible())) fault('narrow: no model');
    await accessible(page, 'narrow', fault);
  });
  await visit({ viewport: NARROW, javaScriptEnabled: false }, async (page) => {
    if (await page.locator('.viewer').isVisible()) fault('without script: an empty viewer');
    for (const list of [guide.made, guide.bought]) {
      for (const { name } of list) {
        const row = page.locator('th', { hasText: name }).first();
        if (!(await row.isVisible())) fault(`without script: no row for ${name}`);
      }
    }
  });
  // Frames are timed again: other programs may have held up the first one.
  for (let i = 0; i < 2; i++) await visit({}, async (page) => (told.frame_ms = Math.min(told.frame_ms, await frame(page))));
  if (!(told.frame_ms <= FIRST_FRAME_MS)) fault(`the first frame after ${told.frame_ms} ms`);
  for (const format of Object.keys(PAPER)) {
    await visit({}, async (page) => (told[format] = await printed(page, format, fault)));
  }
  told.seconds = (Date.now() - began) / 1000;
  console.log(`${folder}: ${JSON.stringify(told)}`);
}

/** From opening the page to the first frame, ms. */
function frame(page) {
  return page.evaluate(() => performance.getEntriesByName('fabkit-first-frame')[0]?.startTime ?? Infinity);
}

/** Everything that the viewer can do changes the picture, and what it tells is what the guide says. */
async function viewer(page, guide, fault, told) {
  told.frame_ms = await frame(page);
  const canvas = page.locator('.viewer canvas');
  const shot = async () => {
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    return canvas.screenshot();
  };
  let before = await shot();
  const changes = async (what, act, least = 0.002) => {
    await act();
    const after = await shot();
    const share = await differing(page, before, after);
    if (!(share >= least)) fault(`${what} changes ${share} of the picture`);
    before = after;
  };
  const cut = page.getByRole('combobox', { name: 'Cut' });
  for (const axis of ['x', 'y', 'z']) await changes(`cutting across ${axis}`, () => cut.selectOption(axis));
  await changes('moving the cut', async () => {
    const range = page.getByLabel('where the cut is');
    const [least, most] = [await range.getAttribute('min'), await range.getAttribute('max')].map(Number);
    await range.fill(String((0.7 * least + 0.3 * most).toFixed(2)));
    // A few thin tools far apart are a small part of the picture.
  }, 0.0005);
  await changes('no cut', () => cut.selectOption(''));
  const groups = page.locator('.viewer-tree legend input');
  for (let i = 0; i < (await groups.count()); i++) {
    // What lies inside is hidden by what lies around it, which goes first.
    await changes(`hiding group ${i}`, () => groups.nth(i).uncheck(), i === 0 ? 0.002 : 0);
  }
  const empty = await shot();
  await changes('showing all', async () => {
    for (let i = 0; i < (await groups.count()); i++) await groups.nth(i).check();
  });
  if ((await differing(page, empty, before)) < 0.01) fault('the model is less than a hundredth of the picture');
  const apart = page.getByRole('slider', { name: 'Apart' });
  if ((await apart.count()) > 0) {
    await changes('taking apart', () => apart.fill('1'));
    await changes('putting together', () => apart.fill('0'));
  }
  const overlays = page.getByRole('group', { name: 'draw' }).getByRole('checkbox');
  for (let i = 0; i < (await overlays.count()); i++) {
    const box = overlays.nth(i);
    await changes(`box ${i} of what is drawn`, () => box.click(), 5e-4);
    await changes(`box ${i} again`, () => box.click(), 5e-4);
  }
  await canvas.focus();
  await changes('an arrow key', () => page.keyboard.press('ArrowLeft'));
  await changes('the view from the front', () => page.getByRole('button', { name: 'Front', exact: true }).click());
  await changes('picking a body', () => pick(page, canvas, fault));
  await facts(page, guide, fault);
  const data = JSON.parse(await page.locator('.viewer script').textContent());
  const { issues } = await validator.validateBytes(new Uint8Array(Buffer.from(data.glb, 'base64')));
  for (const { message, pointer } of issues.messages) fault(`gltf-validator: ${message} at ${pointer}`);
  const scenes = page.getByRole('combobox', { name: 'Show' });
  if ((await scenes.count()) > 0) {
    told.scenes = await scenes.locator('option').count();
    for (let i = 1; i < told.scenes; i++) {
      await scenes.selectOption({ index: i });
      const all = await shot();
      for (const box of await groups.all()) await box.uncheck();
      const share = await differing(page, all, await shot());
      if (share < 0.01) fault(`scene ${i} fills ${share} of the picture`);
    }
  }
}

/** Clicks from the middle outwards until a body is met: some designs are hollow, or several pieces side by side. */
async function pick(page, canvas, fault) {
  const { width, height } = await canvas.boundingBox();
  for (const share of [0, 0.05, -0.05, 0.1, -0.1, 0.2, -0.2, 0.3, -0.3]) {
    for (const [x, y] of [[share, 0], [0, share], [share, share]]) {
      await canvas.click({ position: { x: (0.5 + x) * width, y: (0.5 + y) * height } });
      if ((await page.locator('.viewer-told h3').count()) > 0) return;
    }
  }
  fault('a click tells nothing');
}

/** What is told of each body on a click, against the guide's lists. */
async function facts(page, guide, fault) {
  const listed = new Map([...guide.made, ...guide.bought].map((one) => [one.name, one]));
  let compared = 0;
  for (const button of await page.locator('.viewer-tree li button').all()) {
    const name = await button.textContent();
    if ((await button.getAttribute('aria-pressed')) === 'false') await button.click();
    const read = await page.locator('.viewer-told').evaluate((box) => {
      const terms = [...box.querySelectorAll('dt')].map((term) => [term.textContent, term.nextSibling.textContent]);
      return { name: box.querySelector('h3')?.textContent, ...Object.fromEntries(terms) };
    });
    if (read.name !== name) fault(`${name} is told of as ${read.name}`);
    const one = listed.get(name);
    if (one === undefined) continue;
    compared += 1;
    const summary = one.summary ?? one.what;
    if (read['What it is'] !== summary) fault(`${name}: ${read['What it is']} instead of ${summary}`);
    if (one.material && read.Material !== one.material) fault(`${name}: ${read.Material}, not ${one.material}`);
    const mass_g = Number.parseFloat(read['Mass of one, solid']);
    if (one.mass_g && !(Math.abs(mass_g - one.mass_g) <= 0.006 + 2e-3 * one.mass_g)) {
      fault(`${name}: ${mass_g} g, not ${one.mass_g}`);
    }
  }
  if (compared === 0) fault('nothing in the model is on the lists');
}

async function narrow(page, what, fault) {
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  if (width > NARROW.width) fault(`${what}: ${width} px wide`);
}

async function accessible(page, what, fault) {
  await page.evaluate(AXE);
  const { violations } = await page.evaluate(() => axe.run(document, { resultTypes: ['violations'] }));
  for (const { id, help, nodes } of violations) {
    fault(`${what}: axe ${id}: ${help}: ${nodes.slice(0, 3).map((node) => node.target.join(' ')).join('; ')}`);
  }
}

/** Prints with a link at the start and the end of what must stay whole; both must be on one page. */
async function printed(page, format, fault) {
  await page.emulateMedia({ media: 'print' });
  const count = await page.evaluate((selector) => {
    const whole = [...document.querySelectorAll(selector)].filter((element) => element.getClientRects().length > 0);
    whole.forEach((element, number) => {
      const home = element.matches('tr') ? element.cells[0] : element.matches('svg') ? element.parentElement : element;
      home.style.position = 'relative';
      for (const [end, place] of [['start', 'top:0'], ['end', 'bottom:0']]) {
        const link = document.createElement('a');
        link.href = `https://mark.invalid/${number}/${end}`;
        link.style.cssText = `position:absolute;left:0;${place};width:1px;height:1px;overflow:hidden;display:block`;
        link.textContent = '.';
        home.append(link);
      }
    });
    return whole.length;
  }, WHOLE);
  const names = await page.evaluate((selector) => {
    const whole = [...document.querySelectorAll(selector)].filter((element) => element.getClientRects().length > 0);
    return whole.map((element) => `${element.tagName} ${element.textContent.trim().slice(0, 40)}`);
  }, WHOLE);
  const pdf = await page.pdf({ format, printBackground: true });
  const { pages, links } = linksOf(pdf);
  let marked = 0;
  for (let number = 0; number < count; number++) {
    const [start, end] = ['start', 'end'].map((which) => links.get(`https://mark.invalid/${number}/${which}`)?.[0]);
    if (start === undefined || end === undefined) continue;
    marked += 1;
    if (start !== end) fault(`${format}: ${names[number]} is cut between pages ${start} and ${end}`);
  }
  if (marked < 0.9 * count) fault(`${format}: ${marked} of ${count} marks were found in the PDF`);
  return `${pages} pages, ${marked} pieces looked at`;
}
