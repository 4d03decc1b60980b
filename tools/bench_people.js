// The node library under VS Code's client, timed (bench_people.py): bench_people.js HVI_RUN SCRIPT LINE COLUMN TIMES. Milliseconds of each
// kind are printed as JSON.
const {spawn} = require("child_process");
const {readFileSync} = require("fs");
const {pathToFileURL} = require("url");
const lsp = require("vscode-languageserver-protocol/node");

const [program, script, ...numbers] = process.argv.slice(2);
const [line, column, times] = numbers.map(Number);
const uri = pathToFileURL(script).href;
const out = {"messages after a change": [], "hover": [], "completion": []};

async function timed(kind, work) {
  const start = process.hrtime.bigint();
  const answer = await work();
  if (kind) out[kind].push(Number(process.hrtime.bigint() - start) / 1e6);
  return answer;
}

function demand(holds, what) {
  if (!holds) throw new Error(what);
}

async function main() {
  const server = spawn(program, ["serve-editor"], {stdio: ["pipe", "pipe", "inherit"]});
  const connection = lsp.createProtocolConnection(new lsp.StreamMessageReader(server.stdout), new lsp.StreamMessageWriter(server.stdin));
  const waiting = new Map(); // by version
  connection.onNotification(lsp.PublishDiagnosticsNotification.type, p => {
    if (waiting.has(p.version)) waiting.get(p.version)(p.diagnostics.filter(one => one.severity === 1));
  });
  connection.onRequest("workspace/codeLens/refresh", () => null);
  connection.listen();
  await connection.sendRequest(lsp.InitializeRequest.type, {processId: process.pid, rootUri: null, capabilities: {}});
  await connection.sendNotification(lsp.InitializedNotification.type, {});
  let version = 1;
  const told = () => new Promise(resolve => waiting.set(version, resolve));
  const opened = told();
  await connection.sendNotification(lsp.DidOpenTextDocumentNotification.type,
    {textDocument: {uri, languageId: "hvi", version, text: readFileSync(script, "utf8")}});
  demand((await opened).length === 0, "the script is not right");
  const change = (from, to, text) => {
    version += 1;
    const answer = told();
    connection.sendNotification(lsp.DidChangeTextDocumentNotification.type, {textDocument: {uri, version},
      contentChanges: [{range: {start: {line, character: from}, end: {line, character: to}}, text}]});
    return answer;
  };
  const here = {textDocument: {uri}, position: {line, character: column}};
  for (let turn = 0; turn <= times; ++turn) {
    const kind = turn > 0 ? "messages after a change" : null;
    demand((await timed(kind, () => change(column, column, "x"))).length === 1, "no mistake is told");
    demand((await timed(kind, () => change(column, column + 1, ""))).length === 0, "a mistake stays");
    demand(await timed("hover", () => connection.sendRequest(lsp.HoverRequest.type, here)), "no hover");
    const items = await timed("completion", () => connection.sendRequest(lsp.CompletionRequest.type, here));
    demand((items.items || items).length > 0, "no completion");
  }
  await connection.sendRequest(lsp.ShutdownRequest.type);
  await connection.sendNotification(lsp.ExitNotification.type);
  console.log(JSON.stringify(out));
}

main().then(() => process.exit(0), error => { console.error(error); process.exit(1); });
