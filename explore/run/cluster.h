// Many processes that compute for one: rank 0 runs the command and keeps the store, the others evaluate what it asks.
//
// A point travels, and the answer at it; the function itself goes once to every process that computes it.
// The answers are those that rank 0 would have computed, bit for bit on processors of one kind, so that nothing that
// is kept or reported depends on how many processes there were.
#pragma once

#include "problem/forward_function.h"
#include "run/transport.h"

#include <cstdint>
#include <functional>

namespace explore::run {

using MakeFunction = std::function<std::shared_ptr<const problem::ForwardFunction>(const std::string& description)>;

// How many threads a process computes with when it is not told: its part of the machine.
int threads_of_process(const Transport& transport);

// On every rank but 0: answers until rank 0 leaves. build: what every process must be. Throws std::runtime_error when
// they are not of one build.
void serve(Transport& transport, const std::string& build, const MakeFunction& make_function);

// On rank 0. One object a process.
class Cluster {
public:
    // Waits for the others to say what they offer. Letters are sent and received by a thread of its own.
    Cluster(std::unique_ptr<Transport> transport, const std::string& build);
    ~Cluster(); // sends the others home

    static Cluster* current(); // of this process; nullptr: it is alone

    int own_threads() const; // of this process, when it is not told
    // Of the other processes, in all, when each is to use no more than so many (0: what it offers).
    int threads(int asked) const;

    // The function, computed by this process (at most own_threads at once) or another (at most `asked` at once; 0: what
    // it offers), whichever has a thread free. Itself when it cannot travel. `evaluate` throws Interrupted too. The
    // cluster must outlive it.
    std::shared_ptr<const problem::ForwardFunction> spread(std::shared_ptr<const problem::ForwardFunction> function,
                                                           int own_threads, int asked);

    struct Traffic {
        std::int64_t requests = 0;
        std::int64_t bytes_out = 0, bytes_in = 0;
        double cpu_seconds = 0.0;      // of the other processes in forward runs
        double post_cpu_seconds = 0.0; // of the thread that sends and receives
    };
    Traffic traffic() const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

} // namespace explore::run
