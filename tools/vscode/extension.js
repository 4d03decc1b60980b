// Starts `hvi-run serve-editor` for scripts that are open and lets it answer.
const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = () => {
  const command = workspace.getConfiguration("hvi").get("program");
  client = new LanguageClient("hvi", "hvi-run", { command, args: ["serve-editor"] },
    { documentSelector: [{ language: "hvi" }] });
  return client.start();
};

exports.deactivate = () => client?.stop();
