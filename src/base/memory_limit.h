// How much memory this process may have.
#pragma once

namespace pave {

// Bytes: the machine's memory, or less where the address space of the process (ulimit -v) or its control group (a
// container, a batch job) is limited.
double memory_limit();

} // namespace pave
