#include "lang/check/checker.hpp"

#include "lang/check/stress.hpp"
#include "lang/check/unheeded.hpp"
#include "lang/syntax/tree_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace hvi::lang {

namespace {

/// The first one of the script; null: it has none.
const ast::Find* find_of(const std::vector<ast::Program>& programs) {
  if (programs.empty()) return nullptr;
  for (const ast::Statement& statement : programs[0].statements)
    if (const auto* find = std::get_if<ast::Find>(&statement)) return find;
  return nullptr;
}

/// The word of a statement that only a script itself has; nothing of a declaration.
std::optional<std::pair<std::string_view, Span>> word_of_a_script(const ast::Statement& statement) {
  if (const auto* find = std::get_if<ast::Find>(&statement)) return {{"find", find->keyword}};
  if (const auto* report = std::get_if<ast::Report>(&statement))
    return {{"report", report->keyword}};
  if (const auto* expect = std::get_if<ast::Expect>(&statement))
    return {{"expect", expect->keyword}};
  if (const auto* study = std::get_if<ast::Study>(&statement)) return {{"study", study->keyword}};
  return std::nullopt;
}

/// Does it stand there?
bool has_name(const ast::Expr& e, const std::string& name) {
  bool found = false;
  NameVisitor visitor;
  visitor.use = [&](const std::string& used, const Span&) { found = found || used == name; };
  visit_names(e, visitor);
  return found;
}

} // namespace

Checker::Checker(const std::vector<ast::Program>& programs, const CheckOptions& options,
                 Diagnostics& diagnostics)
    : Evaluator(mistakes_, names_), programs_(programs), options_(options),
      find_(find_of(programs)), mistakes_(programs, diagnostics),
      names_(programs, find_, mistakes_), unknowns_(find_, model_), limits_(programs, mistakes_) {}

std::optional<Model> Checker::run() {
  model_.title = options_.title;
  model_.lacks_columns = mistakes_.has_errors(); // the syntax of a report may be wrong
  names_.collect();
  parameters_.check_defines();
  check_finds();
  locate_pieces();
  const bool readable = find_ && statement_.read(*find_);
  check_declarations();
  if (readable) {
    if (unknowns_.known || meshes_are_good())
      report_.read(programs_[0]);
    else
      model_.lacks_columns = true;
    expectations_.read(programs_[0]);
    expectations_.read_accuracy(*find_);
    studies_.read(programs_[0]);
  }
  if (!mistakes_.has_errors()) tensors_.check_locking();
  if (!mistakes_.has_errors()) {
    check_unused();
    tell_unheeded_settings(*find_, model_, mistakes_);
    tell_stress_of_laws(programs_.front(), model_, unknowns_, mistakes_);
  }
  if (options_.on_name) tell_facts();
  if (mistakes_.has_errors() || !find_) return std::nullopt;
  // They were evaluated when something asked for them.
  std::ranges::sort(model_.params, {},
                    [](const ModelParam& p) { return std::pair(p.span.file, p.span.begin); });
  return std::move(model_);
}

/// Else the number of coordinates is not known, and what is said of places may be wrong.
bool Checker::meshes_are_good() const {
  return std::ranges::none_of(names_.all(), [](const Declaration& d) {
    return std::holds_alternative<ast::Mesh>(*d.statement) && is_poison(d.value);
  });
}

/// Those that nothing uses, too: a wrong line is an error even then.
void Checker::check_declarations() {
  for (int i = 0; i < names_.size(); ++i) {
    Declaration& d = names_[i];
    if (d.program != 0) continue;
    const bool used = d.used;
    const bool other_mesh = std::holds_alternative<ast::Mesh>(*d.statement) && find_;
    if (d.state == Declaration::State::untouched && !other_mesh) value_of(i, d.span);
    if (std::holds_alternative<ast::Superpotential>(*d.statement)) laws_.check_alone(i);
    if (std::holds_alternative<ast::Kernel>(*d.statement) && !used) {
      ast::Expr callee;
      callee.span = d.span;
      callee.node = ast::Reference{d.name};
      memories_.kernel_field(callee, Scope{});
    }
    d.used = used;
  }
}

/// A script has one find statement; its imports have none, and ask for no results.
void Checker::check_finds() {
  for (const ast::Program& program : programs_)
    for (const ast::Statement& statement : program.statements) {
      const auto word = word_of_a_script(statement);
      if (!word) continue;
      if (&program != &programs_[0]) {
        mistakes_.error("E0405", word->second,
                        fmt::format("an imported file declares; it cannot have the statement `{}`",
                                    word->first),
                        "move it to the script");
        continue;
      }
      const auto* find = std::get_if<ast::Find>(&statement);
      if (find != nullptr && find != find_) {
        mistakes_.add(diagnose("E0405", find->keyword, "a script has one find statement")
                          .with_secondary(find_->keyword, "the first one"));
      }
    }
  if (!find_ && !programs_.empty() && !mistakes_.has_errors())
    mistakes_.error("E0404", Span{programs_[0].file, 0, 0}, "the script has no find statement",
                    "state the inequality: `find u in V ... such that for all v in V ... >= ...`");
}

/// The mesh that is put together comes first: the others are its pieces then.
void Checker::locate_pieces() {
  for (int i = 0; i < names_.size(); ++i) {
    const auto* mesh = std::get_if<ast::Mesh>(names_[i].statement);
    if (mesh == nullptr || !std::holds_alternative<ast::Binary>(mesh->value.node)) continue;
    const bool used = names_[i].used;
    value_of(i, mesh->name.span);
    names_[i].used = used;
    return;
  }
}

void Checker::check_unused() {
  for (const Declaration& d : names_.all()) {
    if (d.program != 0) continue;
    if (d.used) {
      warn_of_unused_arguments(*d.statement);
      continue;
    }
    if (std::holds_alternative<ast::Mesh>(*d.statement) && !groups_.mesh_name.empty()) {
      meshes_.report_second(d.span);
      continue;
    }
    mistakes_.add(diagnose("W0101", d.span, fmt::format("`{}` is never used", d.name))
                      .with_help(std::holds_alternative<ast::Fn>(*d.statement)
                                     ? "remove it, or use it in the inequality; its body is "
                                       "checked where it is called"
                                     : "remove it, or use it in the inequality"));
  }
}

/// Arguments of functions, parameters of laws. What a kernel is a function of, and a law, is the
/// language's choice.
void Checker::warn_of_unused_arguments(const ast::Statement& statement) {
  const auto tell = [&](const ast::Name& argument, const ast::Name& of) {
    mistakes_.add(
        diagnose("W0101", argument.span,
                 fmt::format("the argument `{}` of `{}` is never used", argument.text, of.text))
            .with_help("remove it, here and where it is given, or use it"));
  };
  if (const auto* fn = std::get_if<ast::Fn>(&statement))
    for (const ast::Name& argument : fn->parameters)
      if (!has_name(fn->value, argument.text)) tell(argument, fn->name);
  const auto* law = std::get_if<ast::Superpotential>(&statement);
  for (std::size_t i = 0; law != nullptr && i < law->parameters.size(); ++i) {
    const ast::Name& own = law->parameters[i].name;
    const auto reads = [&](const ast::LawParameter& later) {
      return later.value && has_name(*later.value, own.text);
    };
    const auto behind = law->parameters.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    if (!has_name(law->value, own.text) && std::none_of(behind, law->parameters.end(), reads))
      tell(own, law->name);
  }
}

void Checker::tell_facts() const {
  for (const Declaration& d : names_.all()) {
    if (d.state != Declaration::State::done || is_poison(d.value)) continue;
    const auto* mesh = std::get_if<MeshValue>(&d.value);
    options_.on_name({d.span, describe_with_number(d.value),
                      mesh ? groups_.of(*mesh) : std::vector<std::string>{}});
  }
}

std::optional<Model> check(const std::vector<ast::Program>& programs, const CheckOptions& options,
                           Diagnostics& diagnostics) {
  return Checker(programs, options, diagnostics).run();
}

} // namespace hvi::lang
