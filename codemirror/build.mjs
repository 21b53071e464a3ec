// Builds ../i2pdsl/studio/client/codemirror.js, its licences and its hash: `npm ci && node build.mjs`.
// With --check it builds, writes nothing, and fails where the committed files are others.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const built = await build({
  entryPoints: [here("editor.js")],
  absWorkingDir: here("."),
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  charset: "utf8",
  legalComments: "none",
  metafile: true,
  write: false,
});
const code = built.outputFiles[0].text;

// Of each package that went into it: what it is, and its licence as it came with it.
const packages = new Set(
  Object.keys(built.metafile.inputs).flatMap(
    (file) => file.match(/^node_modules\/((?:@[^/]+\/)?[^/]+)/)?.[1] ?? [],
  ),
);
const licences = [...packages].sort().map((name) => {
  const { version, license } = JSON.parse(readFileSync(here(`node_modules/${name}/package.json`)));
  const text = readFileSync(here(`node_modules/${name}/LICENSE`), "utf8").trim();
  return `${name} ${version} (${license})\n\n${text}\n`;
});
const lock = readFileSync(here("package-lock.json"));
const sha256 = (data) => createHash("sha256").update(data).digest("hex");
const files = {
  "codemirror.js": code,
  "codemirror.licences.txt": licences.join(`\n${"-".repeat(72)}\n\n`),
  "codemirror.sha256": `${sha256(code)}  codemirror.js\n${sha256(lock)}  package-lock.json\n`,
};

const check = process.argv.includes("--check");
for (const [name, text] of Object.entries(files)) {
  const place = here(`../i2pdsl/studio/client/${name}`);
  if (!check) writeFileSync(place, text);
  else if (readFileSync(place, "utf8") !== text) {
    console.error(`${name} is not what these sources build: run node build.mjs`);
    process.exitCode = 1;
  }
}
console.log(`codemirror.js: ${code.length} bytes, of ${packages.size} packages`);
