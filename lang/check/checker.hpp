// The checker's working state, shared by check_*.cpp. Public entry: lang/check/check.hpp.
//
// Declarations are evaluated when first used (reading order is free), each at most once; a circle
// is an error. An expression is evaluated to a symbolic Value in a Scope that says what is visible.
#pragma once

#include "lang/check/check.hpp"
#include "lang/check/material_use.hpp"
#include "lang/check/value.hpp"
#include "solver/mesh/geo_constants.hpp"
#include "solver/mesh/mesh.hpp"

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>

namespace hvi::lang {

/// What may be used in an expression, and what the names of its frame stand for.
struct Scope {
  std::string what;      ///< "a parameter", "a load": for messages
  bool position = false; ///< x y z
  bool time = false;     ///< t
  bool lag = false;      ///< lag
  bool normal = false;   ///< normal, and u.nu
  bool unknown = false;  ///< u, u', history(...)
  bool test = false;     ///< v
  bool report = false;   ///< nonlinear in u is welcome; sigma, layer.xi, integral(...)
  bool law = false;      ///< the body of a superpotential
  bool states = false;   ///< states of points
  bool source = false;   ///< a source that reads multipliers of laws, nonlinear in u as it likes
  std::map<std::string, Value> locals;
  Span call; ///< the call that brought us into another file, if any

  [[nodiscard]] bool may_be_nonlinear() const { return report || source; }

  /// The same things visible inside a function, whose arguments are its only locals.
  [[nodiscard]] Scope without_locals() const {
    return {what,   position, time,   lag,    normal, unknown, test,
            report, law,      states, source, {},     call};
  }
};

/// Arguments of a call after matching them with the names the callee knows.
struct Arguments {
  std::map<std::string, const ast::Expr*> named;
  std::vector<const ast::Expr*> positional;
};

/// Jumps that a law's body reads (check_pairs.cpp).
bool has_jumps(const Symbol& symbol); ///< or means
bool has_jumps_and_values(const Symbol& symbol);
/// Of an expression on a pair, where its jumps have become values: are there means in it?
bool has_means(const std::vector<Symbol>& on_pair);
Symbol without_jumps(const Symbol& symbol);

/// Has a form u'' in it, and not times zero? (check_space.cpp)
bool has_acceleration(const ModelTerm& term);

struct Declaration {
  enum class State { untouched, busy, done };
  std::string name;
  Span span; ///< of the name
  int program = 0;
  const ast::Statement* statement = nullptr;
  State state = State::untouched;
  Value value = Poison{};
  bool used = false;
};

/// The place of the i-th entry of a list as written; the whole expression when it is not a list.
Span item_span(const ast::Expr& list, std::size_t i);

class Checker {
public:
  Checker(const std::vector<ast::Program>& programs, const CheckOptions& options,
          Diagnostics& diagnostics);
  std::optional<Model> run();

private:
  // --- names (check_names.cpp)
  void collect_declarations();
  void declare(const ast::Name& name, int program, const ast::Statement& statement);
  bool arguments_differ(const ast::Statement& statement);
  void check_defines();
  void check_unused();
  void tell_facts() const;
  Value reference(const ast::Expr& expr, const std::string& name, const Scope& scope);
  std::optional<Value> built_in_name(const ast::Expr& expr, const std::string& name,
                                     const Scope& scope);
  bool is_silent(const std::string& name) const;
  Value unknown_name(const Span& span, const std::string& name, const Scope& scope);
  std::string nearest(const std::string& name, const Scope& scope);
  Value& value_of(int declaration, const Span& use);
  Value evaluate(Declaration& declaration);
  Value evaluate_param(const ast::Param& param);
  Value defined_value(const ast::Param& param);
  bool is_in_range(const ast::Param& param, double value, ModelParam& entry);
  int find_declaration(const std::string& name) const;

  // --- expressions (check_expr.cpp, check_ops.cpp)
  Value expr(const ast::Expr& e, const Scope& scope);
  Value expr_node(const ast::Expr& e, const Scope& scope);
  bool may_go_deeper(const Span& span, int depth);
  std::optional<Field> field(const ast::Expr& e, const Scope& scope);
  std::optional<Field> scalar(const ast::Expr& e, const Scope& scope);
  std::optional<Symbol> condition(const ast::Condition& c, const Scope& scope);
  std::optional<Symbol> compare(const ast::Compare& c, const Scope& scope);
  Value list(const ast::Expr& e, const ast::List& list, const Scope& scope);
  Value member(const ast::Expr& e, const ast::Member& member, const Scope& scope);
  Value field_member(const ast::Expr& e, const ast::Member& member, const Field& object,
                     const Scope& scope);
  Value part_along_normal(const ast::Member& m, const Field& f, const Scope& scope);
  Value coupled_multiplier(const ast::Member& member, int declaration);
  Value law_member(const ast::Member& member, int declaration, const Scope& scope);
  Value prime(const ast::Expr& e, const ast::Prime& prime, const Scope& scope);
  Value cases(const ast::Expr& e, const ast::Cases& cases, const Scope& scope);
  Value binary(const ast::Expr& e, const ast::Binary& binary, const Scope& scope);
  std::optional<Field> add(const ast::Expr& e, const ast::Binary& b, Field left, Field right,
                           const Scope& scope);
  std::optional<Field> multiply(const ast::Expr& e, const ast::Binary& b, const Field& left,
                                const Field& right, const Scope& scope);
  std::optional<Field> divide(const ast::Expr& e, const ast::Binary& b, const Field& left,
                              const Field& right, const Scope& scope);
  std::optional<Field> contract(const ast::Expr& e, const ast::Binary& b, const Field& left,
                                const Field& right, const Scope& scope);
  std::optional<Field> power(const ast::Expr& e, const Field& left, const Field& right,
                             const Scope& scope);
  /// Degrees of a product; false (reported) when it is not linear.
  bool product_degrees(const Span& span, const Field& left, const Field& right, Field& out,
                       const Scope& scope);
  /// Degrees of f(a, b, ...): must not contain v, nor u outside reports.
  bool nonlinear_degrees(const Span& span, const std::string& what,
                         const std::vector<const Field*>& args, Field& out, const Scope& scope);
  std::optional<Field> dot(const Span& span, const Field& left, const Field& right,
                           const Scope& scope);
  std::optional<Field> dot_in_section(const Span& span, const Field& left, const Field& right,
                                      const Scope& scope);
  bool check_finite(const Span& span, const Field& result);

  // --- constants
  std::optional<double> constant(const ast::Expr& e, const std::string& what);
  std::optional<int> positive_integer(const ast::Expr& e, const std::string& what);
  std::optional<std::vector<double>> constant_list(const ast::Expr& e, const std::string& what);
  std::optional<std::string> word(const ast::Expr& e, const std::string& what,
                                  const std::vector<std::string>& allowed);

  // --- calls (check_calls.cpp, check_tensors.cpp)
  Value call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  Value call_built_in(const ast::Expr& e, const ast::Call& call, const std::string& name,
                      const Scope& scope);
  Value call_function(const ast::Expr& e, const ast::Call& call, int declaration,
                      const Scope& scope);
  Value call_law(const ast::Expr& e, const ast::Call& call, int declaration, const Scope& scope);
  Value pointwise(const ast::Expr& e, const ast::Call& call, const std::string& name,
                  const Scope& scope);
  Value differential(const ast::Expr& e, const ast::Call& call, const std::string& name,
                     const Scope& scope);
  Value mises_call(const ast::Expr& e, const Span& span, const Field& f, const Scope& scope);
  Value identity_call(const ast::Expr& e, const ast::Call& call);
  Value dot_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  Value algebraic(const ast::Expr& e, const ast::Call& call, const std::string& name,
                  const Scope& scope);
  void check_locking();
  bool twists(const Span& span, const Field& tensor);
  void note_material(const Span& span, const Field& value, bool elliptic);
  void place_materials();
  void check_tables();
  Value tensor_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                    const Scope& scope);
  /// A tensor of the model as a value.
  Field tensor_value(solver::TensorSpec spec);
  int add_tensor(solver::TensorSpec spec);
  void name_tensor(Field& value, const ast::Name& name);
  std::optional<Symbol> symbol_of(const ast::Expr* a, const Scope& scope);
  std::optional<Symbols3> three_symbols(const ast::Expr* a, const char* what, const Scope& scope);
  std::optional<std::array<solver::Point, 3>> material_axes(const ast::Expr* a);
  std::optional<solver::Point> material_axis(const ast::Expr* a);
  Value isotropic_call(const ast::Expr& e, const ast::Call& c, const Scope& scope);
  Value voigt_call(const ast::Expr& e, const ast::Call& c, const Scope& scope);
  Value orthotropic_call(const ast::Expr& e, const ast::Call& c, const Scope& scope);
  Value transverse_call(const ast::Expr& e, const ast::Call& c, const Scope& scope);
  Value material_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                      const Scope& scope);
  static Field series_field(const solver::PronySeries& series, const Symbol& at);
  Field prony_through(const solver::Table& table, const Symbol& at, const Span& span, bool taken);
  Value table_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  Value prony_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                   const Scope& scope);
  Value derivative_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  std::optional<bool> takes_constants(const ast::Expr& e, const std::string& callee,
                                      std::span<const ast::Expr* const> others,
                                      std::span<const ast::Expr* const> constants,
                                      const std::string& names);
  Value integral_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  Value extreme_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                     const Scope& scope);
  Value reaction_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  std::optional<int> reported_part(const ast::Expr& e, const std::string& what);
  std::optional<solver::Probe> probe_on_part(const ast::Expr& e, const std::string& what,
                                             const ast::Expr& part, const ast::Expr& of,
                                             const Scope& scope);
  std::optional<int> unknown_given(const ast::Expr& e, const std::string& what);
  int first_vector_unknown() const;
  void name_multipliers(int part, Symbol& expression) const;
  Value number_of(solver::Probe probe);
  Value clarke(const ast::Expr& e, const ast::Clarke& clarke, const Scope& scope);
  std::optional<int> superpotential_of(const ast::Clarke& clarke, const Scope& scope);
  bool is_pair_of_law(const ast::Clarke& clarke, const std::string& law, const Field& at,
                      const Field& direction);
  std::optional<LawUse> law_use(const ast::Clarke& clarke, const Field& at, const Field& direction);
  bool can_stand_here(const ast::Clarke& clarke, int law, const Scope& scope);
  /// Matches positional and named arguments with `names` (the first `required` must be there).
  std::optional<std::vector<const ast::Expr*>> match(const ast::Expr& e, const ast::Call& call,
                                                     const std::string& callee,
                                                     const std::vector<std::string>& names,
                                                     std::size_t required);

  // --- memories (check_history.cpp)
  /// T_m of each memory m, component by component.
  using KernelParts = std::map<int, std::vector<Symbol>>;
  std::optional<Field> kernel_field(const ast::Expr& callee, const Scope& scope);
  std::optional<std::pair<int, double>> known_history(const Symbol& kernel) const;
  std::optional<Field> history_argument(const ast::Expr& e, const ast::Expr& argument,
                                        const Field& kernel, const Scope& scope);
  std::optional<KernelParts> parts_of_kernel(const Field& kernel, const std::string& name);
  bool split_material(const MaterialUse& use, KernelMaterials& out);
  KernelMaterials materials_of_kernel(const Field& kernel, const KernelParts& parts);
  std::vector<Symbol> across_of_memories(const Field& kernel, const KernelParts& strains) const;
  std::vector<Symbol> across_of_history(const Field& kernel, const Field& of,
                                        const KernelParts& parts,
                                        const KernelParts& memories) const;
  Value history_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  void check_kernels_in_time();
  std::optional<Field> total_gradient(const Span& span, const Field& f);
  Field with_hoop(const Field& gradient, const Field& f) const;
  /// Of tensors: 3 on axisymmetric meshes, where zz is along the circles.
  int tensor_dim() const { return model_.mesh.axisymmetric ? 3 : model_.dim; }

  // --- laws (check_laws.cpp)
  bool is_law_parameter(const Value& value, const ast::Expr& given);
  Span place_in_law(const solver::Failure& failure, const Span& otherwise) const;
  void warn_of_unreached_cases(bool radial);
  bool take_readings(const std::string& name, const Span& span, const Symbol& body, bool on_pair,
                     solver::LawSpec& spec);
  // check_sources.cpp
  std::optional<int> source_law(const std::string& name, const Symbol& g, bool on_pair,
                                const Span& span);
  int take_rule(ModelTerm& source, const Symbol& integrand) const;
  bool take_source(ModelTerm& term, const Span& span);
  std::optional<int> law_for(int declaration, bool radial, const Span& use);
  std::optional<std::set<int>> law_fields(const ast::Clarke& clarke, const Field& at);
  std::optional<int> law_unknown(const ast::Clarke& clarke, const Field& at,
                                 const Field& direction);
  bool law_rows(const ast::Clarke& clarke, const Field& at, const Field& direction, LawUse& use);
  bool law_rows_of_sums(const ast::Clarke& clarke, const Field& at, const Field& direction,
                        const std::set<int>& fields, LawUse& use);
  bool stands_before(const ast::Clarke& clarke, const Symbol& own, int field, int unknown);
  std::optional<Field> law_body(int declaration, const Field& argument,
                                const std::map<std::string, Value>& parameters, const Span& use);
  bool is_law_of_vectors(int declaration, const ast::Expr& argument, const Field& at);
  void check_law_alone(int declaration);

  // --- meshes (check_mesh.cpp) and their parts (check_parts.cpp)
  Value mesh(const ast::Mesh& mesh);
  bool mesh_of_call(const ast::Mesh& mesh, const ast::Call& call, const std::string& callee);
  bool coordinates(const ast::Expr* written, int dim, const std::string& what,
                   const std::string& wrong, solver::Point& out);
  bool move_to(const ast::Expr* written, int dim, solver::Point& at);
  // ... of several pieces (check_pieces.cpp)
  void locate_pieces();
  Value mesh_of_pieces(const ast::Mesh& mesh);
  bool add_piece(const ast::Expr& name);
  std::string group_named(const MeshValue& mesh, const std::string& name, const Span& span);
  std::vector<std::string> groups_of(const MeshValue& mesh) const;
  solver::RegionSpec whole(const MeshValue& mesh, const Span& span);
  void second_mesh(const Span& span);
  bool adapted_cells(const ast::Expr* written, solver::MeshSpec& spec);
  bool axisymmetric(const ast::Expr* written, int dim, solver::MeshSpec& spec);
  bool box_of_mesh(std::span<const ast::Expr* const> sizes, const ast::Expr* origin,
                   const ast::Expr* at, solver::MeshSpec& spec);
  bool cells_of_mesh(const ast::Expr& cells, const ast::Expr* pattern, int dim,
                     solver::MeshSpec& spec);
  bool grading_of_mesh(const ast::Expr* written, int dim, solver::MeshSpec& spec);
  bool structured_mesh(const ast::Mesh& mesh, const ast::Call& call, const std::string& name);
  bool constants_of_geometry(ast::Call& call, const std::vector<std::string>& names,
                             solver::GeoConstants& out);
  bool file_mesh(const ast::Mesh& m, const ast::Call& written);
  bool split_along(const ast::Expr* written, solver::MeshSpec& spec);
  solver::RegionSpec group_region(const std::string& group, const Span& span);
  bool geometry_mesh(const ast::Mesh& mesh, const ast::Call& call, const std::string& name);
  std::optional<solver::RegionSpec> region(const ast::Region& region);
  std::optional<solver::RegionSpec> region_term(const ast::RegionTerm& term);
  std::optional<solver::RegionSpec> region_path(const ast::Expr& path);
  std::optional<solver::RegionSpec> mesh_member(const ast::Expr& path, const MeshValue& value,
                                                const std::string& mesh, const ast::Name& name);
  std::optional<solver::RegionSpec> mesh_group(const ast::Expr& path, const ast::Call& call);
  std::optional<solver::RegionSpec> point_region(const ast::Expr& path, const ast::Call& call);
  std::optional<solver::Group::Kind> kind_of(const solver::RegionSpec& region) const;
  std::optional<std::string> allowed_path(const std::string& path, const Span& span);
  /// The index of a part (or of a mesh, as all its cells) by its name.
  std::optional<int> part_index(const ast::Name& name);

  // --- pairs (check_pairs.cpp)
  std::optional<solver::RegionSpec> pair_region(const ast::Expr& path, const ast::Call& call);
  std::optional<solver::RegionSpec> side_of_pair(const ast::Expr& e);
  Value jump_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                  const Scope& scope);
  Value gap_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  bool is_pair(int part) const;
  bool refuse_pair(int part, const Span& span, const std::string& what);
  bool take_jumps(const Span& span, std::vector<Symbol>& components, int part);
  bool take_jumps_at_point(const Span& span, Symbol& expression, solver::Probe& probe);

  // --- the inequality (check_problem.cpp, check_unknowns.cpp, check_space.cpp)
  void find_statement();
  void locate_find();
  std::optional<int> space(const ast::Space& space);
  bool space_domain(const ast::Name& written, int declaration, solver::SpaceSpec& spec);
  std::optional<solver::DirichletSpec> zero_condition(const ast::ZeroCondition& zero, bool vector);
  std::optional<solver::PeriodicSpec> periodic_condition(const ast::PeriodicCondition& periodic,
                                                         bool vector);
  std::optional<int> component_of_space(const std::optional<ast::Name>& written, bool vector);
  bool check_find_names(const ast::Find& find);
  void unknowns(const ast::Find& find);
  // Of a name: which unknown, or whose test function, it is; -1: of none.
  int unknown_named(const std::string& name) const;
  int unknown_tested_by(const std::string& name) const;
  /// "`u`", "`u` or `theta`": for messages.
  std::string names_of_unknowns() const;
  std::string names_of_tests() const;
  const std::string& name_of(int unknown) const;
  int components_of(int unknown) const;
  Value value_of_unknown(int unknown, int order, bool is_test, const Scope& scope) const;
  void imposed_values(const ast::Find& find);
  bool contains(const solver::RegionSpec& larger, const solver::RegionSpec& part) const;
  solver::DirichletSpec* imposed_entry(int unknown, int part, int component);
  std::optional<int> imposed_component(const ast::ImposedValue& imposed, int unknown);
  bool has_shape_of(const ast::ImposedValue& imposed, const Field& value, int unknown,
                    int component);
  solver::DirichletSpec* place_of_imposed(const ast::ImposedValue& imposed, int unknown, int part,
                                          int component, std::set<std::array<int, 3>>& before);
  void imposed_value(const ast::ImposedValue& imposed, std::set<std::array<int, 3>>& before);
  void time_clause(const ast::Find& find);
  void time_grid(const ast::TimeClause& clause);
  void initial_state(const ast::Find& find);
  std::optional<std::vector<Symbol>> initial_value(const ast::InitialValue& initial, int unknown);
  bool is_static_start(const ast::InitialValue& initial) const;
  void check_static_start(const ast::Find& find);
  template <class T>
  void choose(const ast::Setting& setting, const std::string& what,
              const std::vector<std::pair<std::string, T>>& choices, T& out);
  void set_scheme(const ast::Setting& setting);
  void set_hht_alpha(const ast::Setting& setting);
  void set_positive(const ast::Setting& setting, double& out);
  void set_quadrature(const ast::Setting& setting);
  void set_accuracy_of(const ast::Setting& setting);
  void setting(const ast::Setting& setting);
  bool has_second_derivative() const;
  void settings(const ast::Find& find);
  void forms(const ast::Find& find);
  void form_term(const ast::FormTerm& term, bool right, bool source);
  std::optional<Symbol> form_factors(const ast::FormTerm& term);
  void law_factors(ModelTerm& term, const ast::FormTerm& source);

  // --- states (check_states.cpp)
  Value state(int declaration);
  Value hidden_state(const Span& span, int declaration, const Scope& scope);
  void states();
  void state_rate(ModelState& state);
  void state_range(ModelState& state);
  void state_initial(ModelState& state);
  bool is_of_no_mean(const ast::Clarke& c, const Field& at, const Field& direction);
  bool multipliers_on_part(const Span& span, int part, Symbol& expression);
  Symbol without_states_known(Symbol expression, int part) const;
  bool reads_states_of(const Span& span, const Symbol& expression, int part,
                       const std::string& who);
  std::optional<std::vector<int>> take_states(Symbol& expression, const Span& span);
  Symbol clock_on(int part);
  bool take_time(ModelTerm& term, const Span& span);
  bool states_of_form(const ModelTerm& term, const Span& span);
  bool lives_in_body(int part) const;
  void check_states_of_laws();
  void check_changing_form(const ModelTerm& term);
  bool check_integrand(const ModelTerm& term, const ast::FormTerm& written, bool source);
  void check_relation(const ast::Find& find);
  void check_clauses(const ast::Find& find);
  void of_one_unknown();
  void pairs_of_elements(const ast::Find& find);
  void check_one_law_per_part();
  void check_symmetry();

  // --- results (check_report.cpp)
  void reports();
  void table(const ast::TableItem& item);
  void fields(const ast::FieldsItem& item);
  bool from_start(const Span& words);
  void picture(const ast::PictureItem& item);
  bool picture_times(const ast::PictureItem& item, std::vector<std::optional<double>>& out);
  bool picture_factor(const ast::PictureItem& item, double& out);
  bool is_graph(const ast::Expr& e) const;
  void graphs(const ast::PictureItem& item);
  bool graph(const ast::Expr& e, solver::GraphsSpec& out);
  void line(const ast::LineItem& item);
  void plot(const ast::PlotItem& item);
  void plots();
  std::optional<solver::FieldSpec> drawn_field(const ast::Expr& e, const std::string& what);
  bool place(const ast::Expr& e, solver::Point& out);
  void binding(const ast::Binding& binding, solver::TableSpec& table);
  std::optional<Field> column_value(const ast::Binding& binding);
  bool has_one_value(const ast::Binding& binding, const Field& value);
  bool column(const ast::Binding& binding, solver::Probe probe, solver::TableSpec& table);
  void take_at_its_time(std::size_t first, solver::Probe& p);
  std::optional<solver::FieldSpec> output_field(const ast::Expr& e);
  std::optional<std::string> output_name(const std::optional<ast::Text>& to);
  int probe(solver::Probe probe);
  int norm_of_unknown(const ast::Expr& e) const;
  std::optional<double> report_time(const ast::Expr& e);
  Field stress();
  void expectations();
  bool varies(const ast::Name& name, std::vector<std::string>& known);
  bool study_value(const ast::Expr& item, std::vector<std::string>& out);
  std::optional<StudyLadder> study_ladder(const ast::Ladder& ladder, const ModelStudy& study);
  void study();
  std::vector<Symbol> exact_solution(const ast::Expr& written);
  void norm_of_study(const ast::Name& space, ModelStudy& study);

  void error(std::string_view code, const Span& span, std::string message, std::string help = {},
             std::string label = {});

  const std::vector<ast::Program>& programs_;
  const CheckOptions& options_;
  Diagnostics& diagnostics_;
  Model model_;
  std::vector<Declaration> declarations_;
  std::unordered_map<std::string, int> by_name_;
  std::set<std::string> silenced_; ///< names whose statements have syntax errors
  const ast::Find* find_ = nullptr;
  std::string mesh_name_; ///< of the mesh that was declared; empty before
  std::map<std::string, solver::Group::Kind> groups_; ///< of the mesh in use
  bool groups_known_ = false;
  bool making_pieces_ = false;
  std::set<std::string> cuts_;      ///< groups along which the mesh is cut: each is a pair
  std::vector<std::string> pieces_; ///< their names; MeshValue i > 0 is pieces_[i - 1]
  std::map<std::pair<int, bool>, int> law_index_;
  std::map<int, int> clocks_; ///< by part: the state that is t
  /// Cases in the body of the law being checked.
  struct LawCases {
    std::vector<Symbol> conditions;
    std::vector<Span> places, values; ///< of the conditions; of the values, the last one's too
  };
  std::vector<LawCases> law_cases_; ///< inner ones first
  bool reads_multiplier_ = false;   ///< the form term at hand has `slip.xi` in it
  std::string coupled_;             ///< the law whose multiplier the law being checked reads
  std::map<std::size_t, std::pair<Span, double>> locking_; ///< nearly incompressible tensors
  std::set<int> laws_applied_;
  std::set<int> laws_at_hand_;    ///< whose bodies are being read
  std::set<int> laws_in_circle_;  ///< reported: they are defined by themselves
  std::set<std::string> outputs_; ///< names of files given with `to`
  std::map<std::string, int> part_of_;
  /// A table's argument, checked when the times of the problem are known.
  struct TableUse {
    Span span;
    std::string file;
    Symbol at;
    double first, last;
  };
  std::vector<TableUse> table_uses_;
  int gap_part_ = -1;                     ///< whose gap the expression at hand has read
  std::set<int> laws_of_jumps_;           ///< of model_.laws: their bodies read jumps
  int part_at_hand_ = -1;                 ///< of the integral that is read
  int evaluated_ = -1;                    ///< the declaration that is evaluated
  std::vector<int> owners_;               ///< of model_.materials: a declaration, or -1
  std::map<int, std::set<int>> parts_of_; ///< by declaration: parts on which it is used
  std::map<int, std::set<int>> used_by_;  ///< by declaration: declarations that use it
  std::vector<solver::SpaceSpec> spaces_; ///< as declared; SpaceValue is an index
  bool spaces_known_ = false;             ///< those of all unknowns
  bool uses_memory_ = false;
  std::map<std::string, std::string> nearest_; ///< what may be meant by names that are unknown
  std::vector<int> functions_at_hand_;         ///< declarations, as they call one another
  std::vector<Span> calls_;                    ///< of functions and laws that are being evaluated
  long evaluations_ = 0;       ///< of expressions: functions of functions can ask for any number
  long most_evaluations_ = 0;  ///< more for a long script
  int depth_ = 0;              ///< of expressions and declarations that are being evaluated
  int built_ = 0;              ///< the deepest value made inside the expression at hand
  bool too_deep_ = false;      ///< reported
  bool readable_ = true;       ///< the unknown and the test function have names of their own
  bool normal_missed_ = false; ///< in the integral at hand a normal was missed and reported
};

} // namespace hvi::lang
