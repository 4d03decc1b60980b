// The report statements: tables, fields, pictures, curves.
#pragma once

#include "lang/check/curves.hpp"
#include "lang/check/output_fields.hpp"
#include "lang/check/pictures.hpp"
#include "lang/check/results.hpp"
#include "lang/check/tables.hpp"

namespace hvi::lang {

class Report {
public:
  Report(const Context& context, Parts& parts, Pairs& pairs, Probes& probes, Memories& memories,
         Laws& laws)
      : results_(context), tables_(context, parts, pairs, probes, results_),
        fields_(context, results_), pictures_(context, memories, laws, results_, fields_),
        curves_(context, results_, fields_) {}

  void read(const ast::Program& script);
  Results& results() { return results_; }

private:
  void read_item(const ast::ReportItem& item);

  Results results_;
  Tables tables_;
  OutputFields fields_;
  Pictures pictures_;
  Curves curves_;
};

} // namespace hvi::lang
