// One member function for each request; see server.hpp.
#include "lang/editor/server.hpp"

#include "lang/editor/actions.hpp"
#include "lang/editor/completion.hpp"
#include "lang/editor/documents.hpp"
#include "lang/editor/hover.hpp"
#include "lang/editor/judgement.hpp"
#include "lang/editor/messages.hpp"
#include "lang/editor/navigation.hpp"
#include "lang/editor/structure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace hvi::lang {

namespace {

/// Error codes of JSON-RPC 2.0 and of the protocol.
constexpr int parse_error = -32700, invalid_request = -32600, unknown_method = -32601,
              invalid_parameters = -32602, not_initialised = -32002, refused = -32803;

struct RequestError {
  int code;
  std::string message;
};

class Server {
public:
  Server(int input, int output, const CompileSettings& settings, const char* version)
      : settings_(settings), version_(version), reader_(input), output_(output),
        documents_(settings), judgement_([this] { judged_.ring(); }) {}

  int run() {
    while (!done_) {
      if (!reader_.more_waits()) publish();
      if (!reader_.comes_before(judged_)) {
        show_judged();
        continue;
      }
      const auto content = reader_.next();
      if (!content) break;
      take(*content);
    }
    return shut_down_ ? exit_ok : exit_script;
  }

private:
  using Handler = Json (Server::*)(const Json&);

  // --- messages
  void take(const std::string& content) {
    const Json message = Json::parse(content, nullptr, false);
    if (message.is_discarded()) return answer_error(nullptr, {parse_error, "this is no JSON"});
    if (!message.is_object() || !message.contains("method") || !message["method"].is_string()) {
      // An answer to what we asked (a refresh) says nothing that is needed.
      const bool answer = message.is_object() && !message.contains("method");
      if (!answer) answer_error(nullptr, {invalid_request, "a message has a method"});
      return;
    }
    const std::string method = message["method"];
    const Json id = message.value("id", Json());
    const Json parameters = message.value("params", Json::object());
    try {
      const Json result = call(method, parameters, !message.contains("id"));
      if (message.contains("id")) send({{"jsonrpc", "2.0"}, {"id", id}, {"result", result}});
    } catch (const RequestError& error) {
      if (message.contains("id")) answer_error(id, error);
    } catch (const nlohmann::json::exception& error) {
      if (message.contains("id")) answer_error(id, {invalid_parameters, error.what()});
    }
  }

  Json call(const std::string& method, const Json& parameters, bool notification) {
    static const std::map<std::string, Handler> handlers = {
        {"initialize", &Server::initialize},
        {"shutdown", &Server::shutdown},
        {"exit", &Server::exit},
        {"textDocument/didOpen", &Server::did_open},
        {"textDocument/didChange", &Server::did_change},
        {"textDocument/didSave", &Server::did_save},
        {"textDocument/didClose", &Server::did_close},
        {"textDocument/hover", &Server::at<hover>},
        {"textDocument/completion", &Server::at<completion>},
        {"textDocument/signatureHelp", &Server::at<signature>},
        {"textDocument/definition", &Server::at<definition>},
        {"textDocument/documentHighlight", &Server::at<highlights>},
        {"textDocument/prepareRename", &Server::at<renamed_range>},
        {"textDocument/references", &Server::find_references},
        {"textDocument/rename", &Server::rename_name},
        {"textDocument/documentSymbol", &Server::whole<outline>},
        {"textDocument/semanticTokens/full", &Server::whole<colours>},
        {"textDocument/formatting", &Server::whole<formatted>},
        {"textDocument/codeAction", &Server::code_actions},
        {"textDocument/codeLens", &Server::lenses}};
    const auto found = handlers.find(method);
    if (found == handlers.end()) {
      if (notification) return nullptr; // $/cancelRequest, initialized, ...
      throw RequestError{unknown_method, fmt::format("there is no method `{}`", method)};
    }
    if (!initialised_ && method != "initialize" && method != "exit")
      throw RequestError{not_initialised, "the first request is `initialize`"};
    return (this->*found->second)(parameters);
  }

  void send(const Json& message) {
    if (!write_message(output_, message)) done_ = true;
  }
  void answer_error(const Json& id, const RequestError& error) {
    send({{"jsonrpc", "2.0"},
          {"id", id},
          {"error", {{"code", error.code}, {"message", error.message}}}});
  }

  // --- the life of the server
  Json initialize(const Json& parameters) {
    initialised_ = true;
    const auto given = [&](const char* path) {
      const Json::json_pointer pointer(path);
      return parameters.contains(pointer) ? parameters.at(pointer) : Json();
    };
    const Json units = given("/capabilities/general/positionEncodings");
    if (units.is_array() && std::ranges::count(units, Json("utf-8")) > 0)
      unit_ = CharacterUnit::utf8;
    refreshes_ = given("/capabilities/workspace/codeLens/refreshSupport") == Json(true);
    return {{"serverInfo", {{"name", "hvi-run"}, {"version", version_}}},
            {"capabilities", capabilities()}};
  }

  [[nodiscard]] Json capabilities() const {
    return {{"positionEncoding", unit_ == CharacterUnit::utf8 ? "utf-8" : "utf-16"},
            {"textDocumentSync",
             {{"openClose", true}, {"change", 2}, {"save", {{"includeText", false}}}}},
            {"hoverProvider", true},
            {"completionProvider", {{"triggerCharacters", {".", "\"", "(", ","}}}},
            {"signatureHelpProvider", {{"triggerCharacters", {"(", ","}}}},
            {"definitionProvider", true},
            {"referencesProvider", true},
            {"documentHighlightProvider", true},
            {"renameProvider", {{"prepareProvider", true}}},
            {"documentSymbolProvider", true},
            {"documentFormattingProvider", true},
            {"codeActionProvider", {{"codeActionKinds", {"quickfix"}}}},
            {"codeLensProvider", Json::object()},
            {"semanticTokensProvider",
             {{"legend", {{"tokenTypes", colour_names()}, {"tokenModifiers", Json::array()}}},
              {"full", true}}}};
  }

  Json shutdown(const Json&) {
    shut_down_ = true;
    return nullptr;
  }
  Json exit(const Json&) {
    done_ = true;
    return nullptr;
  }

  // --- documents
  static std::string uri_in(const Json& parameters) {
    return parameters.at("textDocument").at("uri").get<std::string>();
  }

  Json did_open(const Json& parameters) {
    const Json& document = parameters.at("textDocument");
    documents_.open(uri_in(parameters), document.at("text").get<std::string>(),
                    document.value("version", Json()));
    judge(uri_in(parameters));
    return nullptr;
  }
  Json did_change(const Json& parameters) {
    documents_.change(uri_in(parameters), parameters.at("contentChanges"),
                      parameters.at("textDocument").value("version", Json()), unit_);
    return nullptr;
  }
  Json did_save(const Json& parameters) {
    judge(uri_in(parameters));
    return nullptr;
  }
  Json did_close(const Json& parameters) {
    documents_.close(uri_in(parameters));
    if (const auto path = path_of(uri_in(parameters))) judgement_.forget(*path);
    send_diagnostics(uri_in(parameters), nullptr, Json::array());
    return nullptr;
  }

  void judge(const std::string& uri) {
    if (const auto path = path_of(uri))
      judgement_.ask(*path, documents_.text(uri), settings_, unit_);
  }
  /// What shows behind the plan, and the numbers.
  void show_judged() {
    judged_.silence();
    for (const std::string& path : judgement_.newly_judged()) documents_.publish_again(path);
    publish();
    if (refreshes_)
      send({{"jsonrpc", "2.0"}, {"id", "lenses"}, {"method", "workspace/codeLens/refresh"}});
  }

  void publish() {
    documents_.for_each_unpublished([&](const std::string& uri, const Json& version) {
      send_diagnostics(uri, version, messages_of(uri));
    });
  }
  /// As far as they are known: those behind the plan come when the text has been judged.
  Json messages_of(const std::string& uri) {
    if (const auto path = path_of(uri))
      if (auto judged = judgement_.messages_of(*path, documents_.text(uri)))
        return *std::move(judged);
    const Analysis* const analysis = documents_.analysis(uri);
    return analysis ? diagnostics_json({*analysis, 0, unit_}) : Json::array();
  }
  void send_diagnostics(const std::string& uri, const Json& version, const Json& all) {
    Json parameters = {{"uri", uri}, {"diagnostics", all}};
    if (version.is_number()) parameters["version"] = version;
    send({{"jsonrpc", "2.0"},
          {"method", "textDocument/publishDiagnostics"},
          {"params", parameters}});
  }

  // --- requests
  const Analysis& open_script(const Json& parameters) {
    const Analysis* const analysis = documents_.analysis(uri_in(parameters));
    if (!analysis) throw RequestError{invalid_parameters, "this script is not open"};
    return *analysis;
  }
  std::uint32_t offset_in(const Analysis& analysis, const Json& position) const {
    return offset_of(analysis.source(),
                     {position.at("line").get<int>(), position.at("character").get<int>()}, unit_);
  }
  EditorPlace place_in(const Json& parameters) {
    const Analysis& analysis = open_script(parameters);
    return {analysis, offset_in(analysis, parameters.at("position")), unit_};
  }

  template <Json (*Answer)(const EditorPlace&)>
  Json at(const Json& parameters) {
    return Answer(place_in(parameters));
  }
  template <Json (*Answer)(const EditorPlace&)>
  Json whole(const Json& parameters) {
    return Answer({open_script(parameters), 0, unit_});
  }

  Json find_references(const Json& parameters) {
    return references(place_in(parameters),
                      parameters.at("context").value("includeDeclaration", true));
  }
  Json rename_name(const Json& parameters) {
    std::string error;
    const Json edits =
        rename(place_in(parameters), parameters.at("newName").get<std::string>(), error);
    if (!error.empty()) throw RequestError{refused, error};
    return edits;
  }
  Json code_actions(const Json& parameters) {
    const Analysis& analysis = open_script(parameters);
    const Json& range = parameters.at("range");
    const Span span{0, offset_in(analysis, range.at("start")),
                    offset_in(analysis, range.at("end"))};
    const std::string uri = uri_in(parameters);
    return actions({analysis, 0, unit_}, span,
                   [&](std::string text) { return documents_.analyse(uri, std::move(text)); });
  }
  /// The numbers of `check` above the find statement.
  Json lenses(const Json& parameters) {
    const Analysis& analysis = open_script(parameters);
    const auto said = judgement_.numbers_of(analysis.script().path);
    Json out = Json::array();
    for (const ast::Statement& statement : analysis.script().programs[0].statements)
      if (const auto* find = std::get_if<ast::Find>(&statement); find && said)
        out.push_back({{"range", EditorPlace{analysis, 0, unit_}.range(find->keyword)},
                       {"command", {{"title", *said}, {"command", ""}}}});
    return out;
  }

  CompileSettings settings_;
  std::string version_;
  MessageReader reader_;
  int output_;
  Documents documents_;
  CharacterUnit unit_ = CharacterUnit::utf16;
  bool initialised_ = false, shut_down_ = false, refreshes_ = false;
  bool done_ = false;
  Bell judged_;
  Judgement judgement_; ///< last: its thread uses the others
};

} // namespace

int serve_editor(int input, int output, const CompileSettings& settings, const char* version) {
  return Server(input, output, settings, version).run();
}

} // namespace hvi::lang
