// Inside the study module: the search behind reach_accuracy. Ladders and the choice are in
// search_ladders.cpp, errors in time in search_time.cpp, the runs and their check in accuracy.cpp.
#pragma once

#include "solver/study/accuracy.hpp"
#include "solver/study/kept_run.hpp"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hvi::solver {

/// Element and grading, which are fixed along a ladder in space.
using Element = std::pair<int, double>;
/// Scheme and base, which are fixed along a ladder in time.
using Clock = std::pair<Scheme, int>;

class Search {
public:
  Search(const Plan& plan, const AccuracyRequest& request, const RunSettings& settings,
         const std::function<void(const std::string&)>& tell, Shown* shown);
  AccuracyResult go();

private:
  [[noreturn]] void give_up(const std::string& why);

  // ---- ladders (search_ladders.cpp)
  const KeptRun& cheap(const Setting& setting, const std::string& purpose);
  const KeptRun* rung(const Setting& setting, const std::string& purpose, bool first);
  std::string first_failure() const;
  void record_distance(const KeptRun& run, const KeptRun& against, double d);
  /// Of what is asked for; gives up where that has no values.
  double distance_between(const KeptRun& coarse, const KeptRun& fine);
  double compared(const KeptRun& coarse, const KeptRun& fine);
  int climb(std::vector<Rung>& rungs, int first, int wanted, const std::string& purpose,
            const std::function<Setting(int)>& at);
  bool has_time_error() const;
  Setting space_setting(Element element, int level) const;
  Setting time_setting(Clock clock, int steps) const;
  /// The grade of meshes that are neither graded nor adapted unless the script says so.
  double plain() const { return family_.adapted() ? adaptive : 1.0; }
  void climb_space(Element element, int rungs);
  void climb_time(Clock clock, int rungs);
  int rungs_to(Clock clock) const;
  bool is_singular() const;
  void choose_candidates();
  void pair_up();

  // ---- choice (search_ladders.cpp)
  /// Settings whose seconds and unknowns grow alike: order, and whether meshes are adapted.
  using Kind = std::pair<int, bool>;
  static Kind kind_of(const Setting& s) { return {s.order, s.grade == adaptive}; }
  static Element element_of(const Setting& s) { return {s.order, s.grade}; }
  static Clock clock_of(const Setting& s) { return {s.scheme, s.base}; }
  ErrorLaw space_law(Element element) const;
  ErrorLaw time_law(Clock clock) const;
  std::vector<Candidate> candidates() const;
  Choice choose();
  bool extend(const Setting& choice);
  bool deepen();

  // ---- errors in time (search_time.cpp)
  bool worth_adapting(const std::optional<Choice>& choice) const;
  void adapt_time();
  std::optional<double> remaining_error(const Setting& half, double seen, double& order);
  bool look_at_time(AccuracyTry& now, const Setting& half, const KeptRun& companion);

  // ---- the run and its check (accuracy.cpp)
  void attempt(const Choice& choice);
  double predicted_seconds(const Setting& setting, const KeptRun& companion);
  void finish(AccuracyTry& now, const KeptRun& run, const KeptRun& companion);
  void tighten(const Setting& refused);

  SettingFamily family_;
  Runner runner_;
  const std::function<void(const std::string&)>& tell_;
  Distance space_distance_;
  AccuracyResult out_;
  double floor_ = 0.0, target_ = 0.0;
  int space_steps_ = 1, deepened_ = 0;
  bool time_adapted_ = false;
  std::vector<Scheme> schemes_;
  std::vector<Element> elements_;
  std::vector<std::pair<Element, Clock>> pairs_;
  std::map<Element, std::vector<Rung>> space_;
  std::map<Clock, std::vector<Rung>> time_;
  std::map<Kind, std::vector<CostPoint>> costs_;
  /// At which level the check of a run was above the wanted error, and its error in space.
  struct Refused {
    double resolution, error;
  };
  std::map<Element, Refused> refused_;
  std::map<Element, int> finest_level_;
  std::map<Clock, int> finest_steps_;
};

} // namespace hvi::solver
