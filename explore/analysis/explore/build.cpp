#include "analysis/explore/build.h"

#include "fe/batch_solver.h"
#include "fe/sparse_solver.h"

#include <Eigen/Core>
#include <fmt/format.h>
#include <nlopt.hpp>
#include <oneapi/tbb/version.h>

namespace explore::analysis {

std::string library_words() {
    return fmt::format("Eigen {}.{}.{}, {}, TBB {}.{}, NLopt {}.{}.{}, {}, {}", EIGEN_WORLD_VERSION,
                       EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, pave::fe::sparse_solver_version(), TBB_VERSION_MAJOR,
                       TBB_VERSION_MINOR, nlopt::version_major(), nlopt::version_minor(), nlopt::version_bugfix(),
                       PAVESCAPE_COMPILER,
                       pave::fe::BatchSolver::rounds_once() ? "lanes that round once" : "lanes that round twice");
}

std::string build_words() {
    return fmt::format("{}, {}", version, library_words());
}

} // namespace explore::analysis
