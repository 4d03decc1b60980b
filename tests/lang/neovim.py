"""The language server driven by Neovim's own client, headless: diagnostics as one types, hover, completion, rename, format, a quick fix;
and started by what docs/editor.md says to write into init.lua.

usage: neovim.py HVI_RUN EXAMPLES"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap

LUA = """
local program, out = os.getenv("HVI_RUN"), {}
local client = vim.lsp.start_client({name = "hvi-run", cmd = {program, "serve-editor"}, root_dir = vim.fn.getcwd()})
vim.lsp.buf_attach_client(0, client)
local function ask(method, params)
  local answers, failed = vim.lsp.buf_request_sync(0, method, params, 20000)
  assert(not failed, method .. ": " .. tostring(failed))
  for _, answer in pairs(answers) do return answer.result end
end
local function here(line, column)
  return {textDocument = vim.lsp.util.make_text_document_params(), position = {line = line, character = column}}
end
local function wait(count)
  assert(vim.wait(20000, function() return #vim.diagnostic.get(0) == count end, 5), "diagnostics: " .. #vim.diagnostic.get(0))
end
local function find(text)
  for i, line in ipairs(vim.api.nvim_buf_get_lines(0, 0, -1, false)) do
    local at = line:find(text, 1, true)
    if at then return i - 1, at - 1, line end
  end
end
assert(vim.wait(20000, function() return vim.lsp.buf.server_ready() end, 5), "the server does not answer")
local hover = ask("textDocument/hover", here(find("B : eps(u)")))
out.hover = hover.contents.value
local line, column, text = find("isotropic(young = 70")
vim.api.nvim_buf_set_text(0, line, column, line, column + 9, {"isotropc"})
wait(1)
local wrong = vim.diagnostic.get(0)[1]
out.diagnostic = {wrong.code, wrong.lnum, wrong.col}
out.actions = {}
local range = {start = {line = line, character = column}, ["end"] = {line = line, character = column + 8}}
local actions = ask("textDocument/codeAction", {textDocument = vim.lsp.util.make_text_document_params(), range = range,
  context = {diagnostics = {{range = range, message = wrong.message, code = wrong.code}}}})
for _, action in ipairs(actions) do table.insert(out.actions, action.title) end
vim.lsp.util.apply_workspace_edit(actions[1].edit, "utf-16")
wait(0)
local row, at = find("slab.top")
out.completion = {}
local items = ask("textDocument/completion", here(row, at + 5))
for _, item in ipairs(items.items or items) do table.insert(out.completion, item.label) end
local from, start = find("part roof")
vim.lsp.util.apply_workspace_edit(ask("textDocument/rename", vim.tbl_extend("force", here(from, start + 5), {newName = "ceiling"})), "utf-16")
out.renamed = table.concat(vim.api.nvim_buf_get_lines(0, 0, -1, false), "\\n")
wait(0)
vim.api.nvim_buf_set_lines(0, 0, 0, false, {"param   extra=1", ""})
local edits = ask("textDocument/formatting", {textDocument = vim.lsp.util.make_text_document_params(), options = {tabSize = 2, insertSpaces = true}})
vim.lsp.util.apply_text_edits(edits, 0, "utf-16")
out.formatted = vim.api.nvim_buf_get_lines(0, 0, 1, false)[1]
vim.fn.writefile({vim.fn.json_encode(out)}, os.getenv("OUT"))
"""


# Two scripts in one window: one server, which answers for both.
AS_THE_PAGE_SAYS = """
vim.cmd("edit second.hvi")
assert(vim.bo.filetype == "hvi" and vim.bo.commentstring == "# %s")
assert(vim.wait(20000, function() return vim.lsp.buf.server_ready() end, 5), "the server does not answer")
assert(#vim.lsp.get_active_clients() == 1, "clients: " .. #vim.lsp.get_active_clients())
assert(vim.wait(20000, function() return #vim.diagnostic.get(0) > 0 end, 5), "no message")
vim.fn.writefile({vim.diagnostic.get(0)[1].code}, os.getenv("OUT"))
"""


def by_the_page(program, examples, folder):
    page = (examples.parent / "docs" / "editor.md").read_text()
    written = re.search(r"In `init.lua`[^\n]*\n\n((?:    .*\n|\n)+)", page)
    script, start, lua, out = (folder / name for name in ("slab.hvi", "init.lua", "page.lua", "page.txt"))
    (folder / "second.hvi").write_text("param n = m\n")
    start.write_text(textwrap.dedent(written[1]))
    lua.write_text(guarded(AS_THE_PAGE_SAYS))
    (folder / "hvi-run").symlink_to(program)
    path = f"{folder}:{os.environ['PATH']}"
    done = subprocess.run(["nvim", "--headless", "-u", str(start), "-c", f"luafile {lua}", str(script)], capture_output=True, text=True,
                          timeout=120, cwd=folder, env={**os.environ, "PATH": path, "OUT": str(out), "HOME": str(folder), "XDG_STATE_HOME": str(folder)})
    assert out.is_file() and out.read_text().startswith("E0"), done.stdout + done.stderr


def guarded(lua):
    return f"local good, said = xpcall(function()\n{lua}\nend, debug.traceback)\nif not good then io.stderr:write(said) end\nvim.cmd('qall!')\n"


def main():
    program, examples = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    if not shutil.which("nvim"):
        return print("no Neovim: nothing was tested")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        script, lua, out = folder / "slab.hvi", folder / "drive.lua", folder / "out.json"
        script.write_text((examples / "slab.hvi").read_text())
        lua.write_text(guarded(LUA))
        done = subprocess.run(["nvim", "--headless", "--clean", "-c", f"luafile {lua}", str(script)], capture_output=True, text=True, timeout=120,
                              cwd=folder, env={**os.environ, "HVI_RUN": str(program), "OUT": str(out), "HOME": temporary, "XDG_STATE_HOME": temporary})
        assert out.is_file(), done.stdout + done.stderr
        found = json.loads(out.read_text())
        by_the_page(program, examples.resolve(), folder)
    assert "isotropic" in found["hover"] or "tensor" in found["hover"], found["hover"]
    assert found["diagnostic"][0] == "E0301", found["diagnostic"]
    assert any("isotropic" in title for title in found["actions"]), found["actions"]
    assert {"top", "bottom", "left", "right"} <= set(found["completion"]), found["completion"]
    assert "roof" not in found["renamed"].split("report")[0].replace("proof", "") and "zero on ceiling" in found["renamed"]
    assert found["formatted"] == "param extra = 1", found["formatted"]
    print("Neovim: hover, diagnostics, quick fix, completion, rename, format; the page's init.lua")


main()
