// See run_pictures.hpp. Used by the Reporter.
#include "solver/results/run_pictures.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/discrete/fields_read.hpp"
#include "solver/linear/vector_stream.hpp"
#include "solver/plan/result_files.hpp"
#include "solver/results/absent.hpp"
#include "solver/results/state_field.hpp"
#include "solver/results/written_files.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace hvi::solver {

RunPictures::RunPictures(const Plan& plan, const Discretisation& d, const Contact& contact,
                         Shown* shown)
    : plan_(plan), discretisation_(d), contact_(contact), pictures_(plan.report.pictures.size()) {
  if (shown != nullptr) shown_.emplace(plan, d, contact, *shown);
  std::size_t places = 0;
  for (const auto& line : plan.report.lines) places += static_cast<std::size_t>(line.points);
  const CellLocator locator(d.mesh, places);
  for (const auto& line : plan.report.lines)
    lines_.emplace_back(line, plan.problem, d, contact, locator);
}

std::vector<Expr> RunPictures::expressions() const {
  std::vector<Expr> out;
  const auto add = [&](const FieldSpec& field) {
    out.insert(out.end(), field.components.begin(), field.components.end());
  };
  for (const auto& picture : plan_.report.pictures) {
    out.push_back(Expr::variable(slot::field(field_of_u(0), slot::value(0))));
    add(picture.field);
  }
  for (const auto& line : plan_.report.lines)
    for (const auto& field : line.fields) add(field);
  if (shown_)
    for (const Expr& e : shown_->expressions()) out.push_back(e);
  return out;
}

bool RunPictures::timed() const {
  const auto has_time = [](const auto& spec) { return spec.time.has_value(); };
  return std::ranges::any_of(plan_.report.pictures, has_time) ||
         std::ranges::any_of(plan_.report.lines, has_time);
}

void RunPictures::take_between(double from, double to, bool first, const StateAt& at) {
  const auto here = [&](const std::optional<double>& time) {
    return time && *time <= to && *time >= from && (*time != from || first);
  };
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    const auto& time = plan_.report.pictures[i].time;
    if (!here(time)) continue;
    const Snapshot& then = at(*time);
    show(i, then);
    if (shown_) shown_->take(i, then);
  }
  for (LineValues& line : lines_)
    if (const auto& time = line.spec().time; here(time)) line.take(contact_, at(*time));
}

void RunPictures::show(std::size_t picture, const Snapshot& snapshot) {
  const auto& spec = plan_.report.pictures[picture];
  const auto& components = spec.field.components;
  const bool at_points = std::ranges::any_of(components, reads_multiplier);
  // Frames have all that is drawn; what lives at points is drawn from them alone.
  if (spec.in_row >= 0 && (shown_ || at_points)) return;
  PictureValues out{snapshot.field(field_of_u(0)), {}};
  if (!at_points) {
    out.values = nodal_values(discretisation_.space, components, snapshot.values());
    forget_where_absent(discretisation_.space, spec.field, false, out.values);
  } else if (StateField::is_one(plan_.problem, contact_, spec.field)) {
    out.values =
        StateField(plan_.problem, discretisation_, contact_, spec.field).of_nodes(snapshot);
  } else {
    return;
  }
  pictures_[picture] = std::move(out);
}

void RunPictures::take_at_end(const Snapshot& now) {
  for (std::size_t i = 0; i < pictures_.size(); ++i)
    if (!plan_.report.pictures[i].time) show(i, now);
  for (LineValues& line : lines_)
    if (!line.spec().time) line.take(contact_, now);
}

void RunPictures::finish(const Snapshot* end, RunResult& result) {
  result.pictures = pictures_;
  if (shown_ && end != nullptr) shown_->finish(*end);
}

void RunPictures::write_lines(const std::filesystem::path& folder, const std::string& name,
                              WrittenFiles& files) const {
  for (std::size_t i = 0; i < lines_.size(); ++i)
    if (lines_[i].taken())
      files.attempt([&] {
        ReportTable table = lines_[i].table();
        table.units = line_units(plan_.report, i, discretisation_.mesh.dim);
        files.add(write_table(folder, line_file(plan_.report, i, name), table));
      });
}

void RunPictures::save(std::ostream& out) const {
  StateWriter w(out);
  for (const auto& [u, values] : pictures_) {
    w.put(static_cast<std::uint8_t>(u.size() > 0));
    if (u.size() == 0) continue;
    put_vector(w, u);
    w.put(values);
  }
  for (const LineValues& line : lines_) line.save(w);
  w.put(static_cast<std::uint8_t>(shown_.has_value()));
  if (shown_) shown_->save(out);
}

void RunPictures::restore(std::istream& in, const Snapshot& now) {
  StateReader r(in, {});
  const Space& space = discretisation_.space;
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    if (r.get<std::uint8_t>() == 0) continue;
    get_vector(r, pictures_[i].u, space.n_dofs());
    pictures_[i].values =
        r.get_vector<double>(space.nodes.size() * plan_.report.pictures[i].field.components.size());
  }
  for (LineValues& line : lines_) line.restore(r);
  const bool with_frames = r.get<std::uint8_t>() != 0;
  if (with_frames != shown_.has_value())
    r.fail(shown_ ? "was saved without pictures" : "was saved with pictures");
  if (shown_) shown_->restore(in, now);
}

} // namespace hvi::solver
