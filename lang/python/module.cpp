// The module hvi._hvi: what the package hvi (lang/python/hvi) is made of. It has no state of its
// own and changes nothing of the process: no signal handlers, no allocation, no locale.
#include "lang/python/model.hpp"
#include "lang/python/objects.hpp"
#include "lang/python/stepping.hpp"

#include <pybind11/stl.h>

namespace py = pybind11;
using namespace hvi::python;

namespace {

RunAsked asked(const py::dict& how) {
  RunAsked out;
  out.output = how["output"].cast<std::string>();
  out.monitors = how["monitors"].cast<bool>();
  out.keep_every = how["keep_every"].cast<int>();
  out.accuracy = how["accuracy"].cast<double>();
  out.accuracy_of = how["accuracy_of"].cast<std::string>();
  out.budget = how["budget"].cast<double>();
  return out;
}

/// An answer that is found on a thread of its own.
template <class Question>
py::dict answered(Watch& watch, const py::object& progress, const Question& question) {
  Answer answer;
  watched([&] { answer = question(); }, watch, progress);
  return to_dict(answer);
}

void define_model(py::module_& module) {
  py::class_<Shared, std::shared_ptr<Shared>>(module, "Shared").def(py::init<>());
  py::class_<Model>(module, "Model")
      .def(py::init<std::string, std::optional<std::string>, bool>())
      .def("describe",
           [](const Model& model, const Defines& defines) {
             Watch watch;
             return answered(watch, py::none(), [&] { return model.describe(defines); });
           })
      .def("run",
           [](const Model& model, const Defines& defines, const py::dict& how,
              const py::object& progress, const std::shared_ptr<Shared>& shared) {
             Watch watch;
             const RunAsked wanted = asked(how);
             return answered(watch, progress,
                             [&] { return model.run(defines, wanted, watch, shared.get()); });
           })
      .def("check",
           [](const Model& model, const Defines& defines) {
             Watch watch;
             return answered(watch, py::none(), [&] { return model.check(defines, watch); });
           })
      .def("plan",
           [](const Model& model, const Defines& defines) {
             Watch watch;
             return answered(watch, py::none(), [&] { return model.plan(defines, watch); });
           })
      .def("steps", [](const Model& model, const Defines& defines) {
        return std::make_shared<Stepping>(model, defines);
      });
}

void define_stepping(py::module_& module) {
  py::class_<Stepping, std::shared_ptr<Stepping>>(module, "Stepping")
      .def(
          "start",
          [](Stepping& of) { return answered(of.watch(), py::none(), [&] { return of.start(); }); })
      .def("advance",
           [](Stepping& of) {
             bool more = false;
             const py::dict answer = answered(of.watch(), py::none(), [&] {
               auto [found, another] = of.advance();
               more = another;
               return std::move(found);
             });
             return py::make_tuple(answer, more);
           })
      .def("set",
           [](Stepping& of, const Defines& defines) {
             return answered(of.watch(), py::none(), [&] { return of.set(defines); });
           })
      .def("conclude",
           [](Stepping& of) {
             return answered(of.watch(), py::none(), [&] { return of.conclude(); });
           })
      .def_property_readonly("step", &Stepping::step)
      .def_property_readonly("steps", &Stepping::steps)
      .def_property_readonly("t", &Stepping::t)
      .def("values", &Stepping::values)
      .def("fields", [](const Stepping& of) { return to_dict(of.unknowns()); })
      .def("grid", [](const Stepping& of) { return to_dict(of.grid()); });
}

} // namespace

PYBIND11_MODULE(_hvi, module) {
  module.doc() = "What the package hvi is made of.";
  module.attr("version") = HVI_VERSION;
  define_model(module);
  define_stepping(module);
}
