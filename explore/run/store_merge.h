// Two stores of one study, written on machines without a common disk, become one.
#pragma once

#include "run/store.h"

namespace explore::run {

struct MergeReport {
    std::size_t runs = 0;        // of the merged store
    std::size_t evaluations = 0; // of the merged store
    std::size_t added = 0;       // evaluations that the first did not have
    std::size_t compared = 0;    // that both had, the same to the last bit
    std::string libraries{};     // where the two were computed with others: both, in words
};

// The store in the folder `first` gets what that of `second` has: runs, evaluations with and without an answer, the
// sessions that computed them and the files that those read. All of it in one transaction: where the two cannot be one,
// and where the process is ended, the first is as it was. The second is only read.
// Of a design, equal numbers are the same point. In a search they need not be (what took too long has a number and is
// not kept): there equal parameters are, and what has a number that is taken is kept at the end.
// Throws pave::Error: no store, other studies, other versions of the program, an evaluation that differs.
MergeReport merge_stores(const std::string& first, const std::string& second);

// A store like that of `folder` in `copy`, which has none; whoever looks meets a whole one or none. Throws pave::Error.
void copy_store(const std::string& folder, const std::string& copy);

} // namespace explore::run
