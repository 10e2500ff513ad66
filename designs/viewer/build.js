// Bundles the viewer into one file without a request in it, with the licence of what is in it in front:
// `node build.js [FOLDER]`, else into the crate that puts it into pages.

import { build } from 'esbuild';
import { readFileSync, writeFileSync, mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = fileURLToPath(new URL('.', import.meta.url));
const folder = process.argv[2] ?? join(here, '../guide/src/viewer');
const three = join(here, 'node_modules/three');
const { version } = JSON.parse(readFileSync(join(three, 'package.json'), 'utf8'));
const licence = readFileSync(join(three, 'LICENSE'), 'utf8').trim();

const { outputFiles } = await build({
  absWorkingDir: here,
  entryPoints: ['src/main.js'],
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2022',
  charset: 'ascii',
  legalComments: 'none',
  banner: { js: `/* With three.js ${version}:\n\n${licence}\n*/` },
  write: false,
});
mkdirSync(folder, { recursive: true });
writeFileSync(join(folder, 'viewer.js'), outputFiles[0].contents);
console.log(`${join(folder, 'viewer.js')}: ${outputFiles[0].contents.length} bytes`);
