#include "run/transport.h"

#include <cstdlib>
#include <limits>
#include <list>
#include <mpi.h>
#include <stdexcept>

namespace explore::run {
namespace {

void check(int code, const char* what) {
    if (code != MPI_SUCCESS) {
        throw std::runtime_error(std::string("MPI: ") + what + " failed");
    }
}

class Mpi final : public Transport {
public:
    Mpi() {
        int level = 0;
        check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &level), "MPI_Init_thread");
        MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
        MPI_Comm_size(MPI_COMM_WORLD, &ranks_);
        MPI_Comm machine = MPI_COMM_NULL;
        check(MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine),
              "MPI_Comm_split_type");
        MPI_Comm_size(machine, &ranks_of_this_machine_);
        MPI_Comm_free(&machine);
    }
    ~Mpi() override {
        for (auto& sent : sent_) {
            MPI_Wait(&sent.request, MPI_STATUS_IGNORE);
        }
        MPI_Finalize();
    }

    int rank() const override { return rank_; }
    int ranks() const override { return ranks_; }
    int ranks_of_this_machine() const override { return ranks_of_this_machine_; }

    void send(int rank, std::string bytes) override {
        if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
            throw std::runtime_error("MPI: a letter of more than 2 GB");
        }
        Sent& sent = sent_.emplace_back();
        sent.bytes = std::move(bytes);
        check(MPI_Isend(sent.bytes.data(), static_cast<int>(sent.bytes.size()), MPI_BYTE, rank, 0, MPI_COMM_WORLD,
                        &sent.request),
              "MPI_Isend");
    }

    std::optional<Letter> receive() override {
        sent_.remove_if([](Sent& sent) {
            int gone = 0;
            check(MPI_Test(&sent.request, &gone, MPI_STATUS_IGNORE), "MPI_Test");
            return gone != 0;
        });
        int here = 0;
        MPI_Status status;
        check(MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &here, &status), "MPI_Iprobe");
        if (here == 0) {
            return std::nullopt;
        }
        int size = 0;
        MPI_Get_count(&status, MPI_BYTE, &size);
        Letter letter{status.MPI_SOURCE, std::string(static_cast<std::size_t>(size), '\0')};
        check(MPI_Recv(letter.bytes.data(), size, MPI_BYTE, letter.rank, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE),
              "MPI_Recv");
        return letter;
    }

private:
    struct Sent {
        std::string bytes;
        MPI_Request request = MPI_REQUEST_NULL;
    };
    std::list<Sent> sent_;
    int rank_ = 0;
    int ranks_ = 1;
    int ranks_of_this_machine_ = 1;
};

// A number in the environment: by Open MPI, or by others that keep to PMI (MPICH, Slurm).
int said_by_launcher(const char* open_mpi, const char* pmi, int otherwise) {
    for (const char* name : {open_mpi, pmi}) {
        if (const char* value = std::getenv(name)) {
            return std::atoi(value);
        }
    }
    return otherwise;
}

} // namespace

bool begun_by_mpi() {
    return said_by_launcher("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", 1) > 1;
}

bool is_first_of_job() {
    return said_by_launcher("OMPI_COMM_WORLD_RANK", "PMI_RANK", 0) == 0;
}

std::unique_ptr<Transport> join_mpi() {
    return std::make_unique<Mpi>();
}

} // namespace explore::run
