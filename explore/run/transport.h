// Letters between the processes of one parallel job.
#pragma once

#include <memory>
#include <optional>
#include <string>

namespace explore::run {

struct Letter {
    int rank = 0; // of the sender
    std::string bytes;
};

// Functions of one object are called by one thread at a time. Letters between two ranks arrive in the order they were
// sent.
class Transport {
public:
    virtual ~Transport() = default; // leaves the job, when all letters are gone
    virtual int rank() const = 0;
    virtual int ranks() const = 0;
    virtual int ranks_of_this_machine() const = 0;
    virtual void send(int rank, std::string bytes) = 0; // does not wait
    virtual std::optional<Letter> receive() = 0;        // what has arrived, without waiting
};

// Whether a launcher of MPI started this process, and the program was built with MPI.
bool begun_by_mpi();
// Whether it is rank 0 by what the launcher says, or alone.
bool is_first_of_job();
// Joins the job. Throws std::runtime_error. Once a process.
std::unique_ptr<Transport> join_mpi();

} // namespace explore::run
