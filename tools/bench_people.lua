-- Neovim's own client, timed (bench_people.py). Milliseconds of each kind go into the file OUT.
local program, line, column, times = os.getenv("HVI_RUN"), tonumber(os.getenv("LINE")), tonumber(os.getenv("COLUMN")), tonumber(os.getenv("TIMES"))
local out = {["messages after a change"] = {}, hover = {}, completion = {}}

local told -- mistakes in the last messages
local show = vim.lsp.handlers["textDocument/publishDiagnostics"]
vim.lsp.handlers["textDocument/publishDiagnostics"] = function(failed, result, ...)
  show(failed, result, ...)
  told = #vim.tbl_filter(function(one) return one.severity == 1 end, result.diagnostics)
end

local function timed(kind, work)
  local start = vim.loop.hrtime()
  work()
  table.insert(out[kind], (vim.loop.hrtime() - start) / 1e6)
end

-- Until messages have come with so many mistakes among them.
local function wait(count)
  assert(vim.wait(60000, function() return told == count end, 1), tostring(told) .. " mistakes, not " .. count)
end

local function ask(method)
  local params = {textDocument = vim.lsp.util.make_text_document_params(), position = {line = line, character = column}}
  local answers, failed = vim.lsp.buf_request_sync(0, method, params, 60000)
  assert(answers and not failed, method .. ": " .. tostring(failed))
  for _, answer in pairs(answers) do assert(answer.result and next(answer.result), method .. " answers nothing") end
end

local good, said = xpcall(function()
  local client = vim.lsp.start_client({name = "hvi-run", cmd = {program, "serve-editor"}, root_dir = vim.fn.getcwd(),
    flags = {debounce_text_changes = 0}})
  vim.lsp.buf_attach_client(0, client)
  assert(vim.wait(60000, function() return vim.lsp.buf.server_ready() end, 1), "the server does not answer")
  for turn = 1, times + 1 do
    local keep = turn > 1 and "messages after a change"
    if not keep then out.first = {} end
    timed(keep or "first", function() vim.api.nvim_buf_set_text(0, line, column, line, column, {"x"}); wait(1) end)
    timed(keep or "first", function() vim.api.nvim_buf_set_text(0, line, column, line, column + 1, {""}); wait(0) end)
    timed("hover", function() ask("textDocument/hover") end)
    timed("completion", function() ask("textDocument/completion") end)
  end
  out.first = nil
  vim.fn.writefile({vim.fn.json_encode(out)}, os.getenv("OUT"))
end, debug.traceback)
if not good then io.stderr:write(said) end
vim.cmd("qall!")
