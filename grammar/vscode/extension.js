"use strict";
// Starts `stlc lsp` for mission files; all that is known of the language is on its side.
const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = () => {
  const [command, ...args] = vscode.workspace.getConfiguration("stlc").get("command");
  client = new LanguageClient("stlc", "stlc missions", { command, args }, {
    documentSelector: [{ language: "stlc" }],
  });
  return client.start();
};

exports.deactivate = () => client && client.stop();
