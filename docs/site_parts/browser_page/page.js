// The page: files in, one command, what it prints, its pictures and files to keep.
const at = (id) => document.getElementById(id);
const say = (text) => { at("state").textContent = text; };
const READY = "Ready. Files stay in this page: nothing is sent.";
const RUNTIME = "Python for browsers (Pyodide) is not beside this page. Take the full folder of its release and build "
  + "these pages with it: make docs PYODIDE=folder";

function busy(is) {
  at("go").disabled = at("words").disabled = is;
}

function begun({ lacking, version }) {
  if (!lacking) {
    say(`jkr ${version}. ${READY}`);
    busy(false);
  } else if (lacking.includes("pyodide")) say(RUNTIME);
  else say(`The folder of Pyodide lacks ${lacking.join(", ")}: take that of the full release.`);
}

function show({ code, text, files }) {
  at("text").textContent = text;
  const pictures = files.filter(({ name }) => name.endsWith(".svg"));
  at("pictures").replaceChildren(...pictures.map(({ name, bytes }) => {
    const picture = new Image();
    picture.src = URL.createObjectURL(new Blob([bytes], { type: "image/svg+xml" }));
    picture.alt = name;
    return picture;
  }));
  at("files").replaceChildren(...files.map(({ name, bytes }) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([bytes]));
    link.download = name.split("/").pop();
    link.textContent = name;
    return link;
  }));
  say(code ? `Exit code ${code}.` : READY);
  busy(false);
}

async function take(files) {
  for (const file of files) {
    worker.postMessage({ file: { name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) } });
    const item = document.createElement("li");
    item.textContent = file.name;
    at("given").append(item);
  }
}

let worker;
if (location.protocol === "file:") say("Open this page from a server: python -m http.server -d build/docs");
else {
  worker = new Worker("worker.js", { type: "module" });
  worker.onmessage = ({ data }) => {
    if (data.begun) begun(data.begun);
    if (data.answer) show(data.answer);
    if (data.failed) { say(data.failed); busy(!at("text").textContent); }
  };
  worker.postMessage({ begin: true });
  at("form").onsubmit = (event) => {
    event.preventDefault();
    busy(true);
    say("Running ...");
    worker.postMessage({ words: at("words").value });
  };
  at("chosen").onchange = () => take(at("chosen").files);
  document.ondragover = (event) => event.preventDefault();
  document.ondrop = (event) => { event.preventDefault(); take(event.dataTransfer.files); };
  at("examples").onclick = ({ target }) => { if (target.tagName === "BUTTON") at("words").value = target.textContent; };
}
