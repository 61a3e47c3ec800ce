// Python beside the page: the runtime in pyodide/, jkr from its wheel, one command at a time.
let python, run;

async function begin() {
  const setup = await (await fetch("setup.json")).json();
  if (!setup.runtime) return { lacking: ["pyodide"] };
  const { loadPyodide } = await import("./pyodide/pyodide.mjs");
  python = await loadPyodide({ indexURL: new URL("pyodide/", self.location).href });
  await python.loadPackage(setup.packages, { messageCallback: () => {}, errorCallback: () => {} }).catch(() => {});
  const lacking = setup.packages.filter((name) => !(name in python.loadedPackages));
  if (lacking.length) return { lacking };
  await python.loadPackage(new URL(setup.wheel, self.location).href, { messageCallback: () => {} });
  python.FS.mkdir("/work");
  python.FS.chdir("/work");
  python.FS.writeFile("/session.py", await (await fetch("session.py")).text());
  python.runPython("import sys; sys.path.append('/')");
  run = python.pyimport("session").run;
  return { version: setup.version };
}

function command(words) {
  const answer = run(words).toJs({ dict_converter: Object.fromEntries });
  answer.files = answer.files.map((name) => ({ name, bytes: python.FS.readFile(name) }));
  return answer;
}

self.onmessage = async ({ data }) => {
  try {
    if (data.begin) self.postMessage({ begun: await begin() });
    if (data.file) python.FS.writeFile(data.file.name, data.file.bytes);
    if (data.words) self.postMessage({ answer: command(data.words) });
  } catch (error) {
    self.postMessage({ failed: String(error) });
  }
};
