// Shared by the pages of several commands.
#pragma once

#include "analysis/common/session.h"
#include "report/table.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace explore::report {

// "asphalt 30 mm linear | base 277 mm uzan | ..." and what is varied.
std::string study_summary(const study::Study& study);

// The same with what is measured and requested.
std::string readings_summary(const study::Study& study);

// The sign convention, for the header of every table of responses.
inline constexpr std::string_view sign_convention =
    "deflection: positive down; strain and load-induced stress: positive in compression";

// The same, or that a model of the study's own has its own.
std::string_view signs(const study::Study& study);

// Measured against modelled, one row a response, with the line that states the signs. weights: of some of the
// responses, in a column of its own where there are any.
std::string response_table(const study::Study& study, const std::vector<double>& responses,
                           const std::map<std::size_t, double>& weights = {});

// A line a load: what a reduced model is worth.
std::string reduced_words(const analysis::ReducedProblem& reduced);

// A thickness that is enough, in whole millimetres, up to the largest that was looked at: "85", "> 300".
std::string millimetres(const std::optional<double>& mm, double most);

// A line a sentence.
std::string sentences(const std::vector<std::string>& text);

// A line a warning of a run.
std::string warning_lines(const problem::Evaluation& evaluation);

// The header of a table with a column a parameter.
std::vector<std::string> with_axes(std::vector<std::string> before, const problem::ParameterSpace& space,
                                   const std::vector<std::string>& after = {});

} // namespace explore::report
