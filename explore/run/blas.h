// The BLAS of the machine, which the sparse factorisations call inside parallel tasks.
#pragma once

namespace explore::run {

// Keeps OpenBLAS, where it is the machine's BLAS, from starting threads of its own inside every task. False when it
// is a build of OpenBLAS without threads: that one shares its work space between callers and returns wrong numbers
// when two tasks use it at once.
bool prepare_blas();

// Whether so many threads can work: OpenBLAS waits for ever where a thread finds no room for its buffer.
bool blas_has_room(int threads);

} // namespace explore::run
