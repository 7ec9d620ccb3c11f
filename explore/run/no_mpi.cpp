#include "run/transport.h"

#include <stdexcept>

namespace explore::run {

bool begun_by_mpi() {
    return false;
}

bool is_first_of_job() {
    return true;
}

std::unique_ptr<Transport> join_mpi() {
    throw std::runtime_error("the program was built without MPI");
}

} // namespace explore::run
