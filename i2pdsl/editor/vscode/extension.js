// Starts `i2p lsp` and leaves everything else to it.
"use strict";

const vscode = require("vscode");
const { LanguageClient, TransportKind } = require("vscode-languageclient/node");

let client;

async function activate() {
  const command = vscode.workspace.getConfiguration("i2p").get("command") || "i2p";
  const server = { command, args: ["lsp"], transport: TransportKind.stdio };
  const options = {
    documentSelector: [{ language: "story" }, { language: "i2p-world" }],
  };
  client = new LanguageClient("i2p", "i2p stories", server, options);
  try {
    await client.start();
  } catch (problem) {
    client = undefined;
    vscode.window.showErrorMessage(
      `\`${command} lsp\` does not start (${problem.message}). ` +
        "Install it with pip install 'i2pdsl[lsp]', or set i2p.command to its path.",
    );
  }
}

function deactivate() {
  return client ? client.stop() : undefined;
}

module.exports = { activate, deactivate };
