// The verdict of a diagnosis in sentences.
#pragma once

#include "analysis/diagnose/diagnose.h"

namespace explore::analysis {

// The most probable explanation and its probability, the others, and what stands in the way.
std::vector<std::string> verdict_words(const DiagnoseResult& result);

// A hypothesis of the ledger in words: "the noise is some 1.5 times as large as stated".
std::string row_words(const diagnose::Row& row);

// "0.02", "less than 1 in 10,000"
std::string chance_words(double p);

} // namespace explore::analysis
