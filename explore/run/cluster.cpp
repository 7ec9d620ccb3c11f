#include "run/cluster.h"

#include "data/hash.h"
#include "problem/workspaces.h"
#include "run/parallel.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <fmt/format.h>
#include <list>
#include <map>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>
#include <unistd.h>

namespace explore::run {
namespace {

using problem::ForwardFunction;
using problem::Prediction;
using Json = nlohmann::json;
using Answer = pave::Outcome<Prediction>;
using namespace std::chrono_literals;

// Letters, in CBOR: doubles travel bit for bit.
//   hello     rank k to 0   ["hello", build, threads]
//   ask       0 to k        ["ask", ticket, function, points, with jacobian, description or "", at once]
//   tell      k to 0        ["tell", ticket, CPU seconds, kind, ...]
//   home      0 to k        ["home"]
enum class Kind { answers, no_memory, unknown_function, broken };

std::string packed(const Json& json) {
    std::string bytes;
    Json::to_cbor(json, bytes);
    return bytes;
}

Json told(const Prediction& p) {
    return {p.responses,       p.jacobian.rows(),
            p.jacobian.cols(), std::vector<double>(p.jacobian.data(), p.jacobian.data() + p.jacobian.size()),
            p.warnings,        p.in_place_of_reduced};
}

Prediction prediction_of(const Json& json) {
    Prediction p;
    json.at(0).get_to(p.responses);
    const auto numbers = json.at(3).get<std::vector<double>>();
    p.jacobian = Eigen::Map<const Eigen::MatrixXd>(numbers.data(), json.at(1), json.at(2));
    json.at(4).get_to(p.warnings);
    json.at(5).get_to(p.in_place_of_reduced);
    return p;
}

// Between two looks at the post: short while letters come, longer when none do.
class Patience {
public:
    std::chrono::microseconds next() {
        const auto now = wait_;
        wait_ = std::min(2 * wait_, longest);
        return now;
    }
    void letter_came() { wait_ = shortest; }

private:
    static constexpr std::chrono::microseconds shortest = 20us, longest = 1000us;
    std::chrono::microseconds wait_ = shortest;
};

// A function with its workspaces.
class Pooled {
public:
    explicit Pooled(std::shared_ptr<const ForwardFunction> function)
        : function_(std::move(function)),
          workspaces_(*function_) {}
    Answer evaluate(std::span<const double> values, bool with_jacobian) {
        return workspaces_.lend([&](auto& workspace) { return function_->evaluate(values, with_jacobian, workspace); });
    }
    std::vector<Answer> evaluate_many(std::span<const std::vector<double>> points, bool with_jacobian) {
        return workspaces_.lend(
            [&](auto& workspace) { return function_->evaluate_many(points, with_jacobian, workspace); });
    }
    std::size_t lanes() const { return function_->lanes(); }

private:
    std::shared_ptr<const ForwardFunction> function_;
    problem::Workspaces workspaces_;
};

// The memory of a serving process: the functions used last.
class Functions {
public:
    // nullptr: unknown.
    std::shared_ptr<Pooled> find(const std::string& key) {
        const std::scoped_lock lock(mutex_);
        for (auto it = known_.begin(); it != known_.end(); ++it) {
            if (it->first == key) {
                known_.splice(known_.begin(), known_, it);
                return known_.front().second;
            }
        }
        return nullptr;
    }
    std::shared_ptr<Pooled> add(const std::string& key, std::shared_ptr<const ForwardFunction> function) {
        auto entry = std::make_shared<Pooled>(std::move(function));
        const std::scoped_lock lock(mutex_);
        known_.emplace_front(key, entry);
        if (known_.size() > most) {
            known_.pop_back();
        }
        return entry;
    }

private:
    static constexpr std::size_t most = 16;
    std::mutex mutex_;
    std::list<std::pair<std::string, std::shared_ptr<Pooled>>> known_; // the one used last in front
};

Json compute(const Json& ask, Functions& functions, const MakeFunction& make_function) {
    const auto key = ask.at(2).get<std::string>();
    auto known = functions.find(key);
    if (known == nullptr) {
        const auto description = ask.at(5).get<std::string>();
        if (description.empty()) {
            return Json::array({Kind::unknown_function});
        }
        known = functions.add(key, make_function(description));
    }
    const auto points = ask.at(3).get<std::vector<std::vector<double>>>();
    const bool with_jacobian = ask.at(4);
    const bool at_once = ask.at(6);
    Json answers = Json::array();
    for (const Answer& answer : at_once ? known->evaluate_many(points, with_jacobian)
                                        : std::vector{known->evaluate(points.at(0), with_jacobian)}) {
        answers.push_back(answer ? Json::array({told(*answer)})
                                 : Json::array({answer.failure().status, answer.failure().reason}));
    }
    return Json::array({Kind::answers, std::move(answers)});
}

Json answer_to(const Json& ask, Functions& functions, const MakeFunction& make_function) {
    try {
        return compute(ask, functions, make_function);
    } catch (const std::bad_alloc&) {
        return Json::array({Kind::no_memory});
    } catch (const std::exception& error) {
        return Json::array({Kind::broken, error.what()});
    }
}

} // namespace

int threads_of_process(const Transport& transport) {
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    const int allowed = static_cast<int>(std::thread::hardware_concurrency()); // where a launcher has bound it
    return std::max(1, std::min(allowed, static_cast<int>(processors) / transport.ranks_of_this_machine()));
}

void serve(Transport& transport, const std::string& build, const MakeFunction& make_function) {
    const int threads = threads_of_process(transport);
    transport.send(0, packed({"hello", build, threads}));
    Functions functions;
    std::mutex mutex;
    std::condition_variable work_came;
    std::deque<Json> asked;
    std::deque<std::string> done;
    bool home = false;
    std::vector<std::thread> workers;
    workers.reserve(static_cast<std::size_t>(threads));
    for (int t = 0; t < threads; ++t) {
        workers.emplace_back([&] {
            for (;;) {
                Json ask;
                {
                    std::unique_lock lock(mutex);
                    work_came.wait(lock, [&] { return home || !asked.empty(); });
                    if (home) {
                        return;
                    }
                    ask = std::move(asked.front());
                    asked.pop_front();
                }
                const std::int64_t begin = thread_cpu_ns();
                Json tell = answer_to(ask, functions, make_function);
                std::string bytes =
                    packed({"tell", ask.at(1), 1e-9 * static_cast<double>(thread_cpu_ns() - begin), std::move(tell)});
                const std::scoped_lock lock(mutex);
                done.push_back(std::move(bytes));
            }
        });
    }
    Patience patience;
    bool refused = false;
    while (!home) {
        bool quiet = true;
        while (auto letter = transport.receive()) {
            quiet = false;
            Json json = Json::from_cbor(letter->bytes);
            const std::scoped_lock lock(mutex);
            if (json.at(0) == "home") {
                home = true;
                refused = json.size() > 1;
                break;
            }
            asked.push_back(std::move(json));
            work_came.notify_one();
        }
        for (;;) {
            std::string bytes;
            {
                const std::scoped_lock lock(mutex);
                if (done.empty()) {
                    break;
                }
                bytes = std::move(done.front());
                done.pop_front();
            }
            quiet = false;
            transport.send(0, std::move(bytes));
        }
        if (quiet) {
            std::this_thread::sleep_for(patience.next());
        } else {
            patience.letter_came();
        }
    }
    work_came.notify_all();
    for (std::thread& worker : workers) {
        worker.join();
    }
    if (refused) {
        throw std::runtime_error("the processes of the job are not of one build");
    }
}

struct Cluster::Implementation {
    struct Ticket {
        std::optional<Json> tell;
        bool abandoned = false;
    };
    struct Rank {
        int offered = 0; // threads; of rank 0, this process, unless it is told
        int in_use = 0;
    };

    std::unique_ptr<Transport> transport; // of the post, while that runs
    mutable std::mutex mutex;
    std::condition_variable slot_came; // some thread is free
    std::condition_variable told;      // some letter came
    std::condition_variable post_came; // something is to be sent
    std::vector<Rank> ranks;
    bool joined = false;
    bool leaving = false;
    std::exception_ptr failure; // of the post
    std::deque<std::pair<int, std::string>> out;
    std::map<std::int64_t, Ticket> tickets;
    std::int64_t next_ticket = 0;
    std::map<std::string, std::vector<char>> sent; // which rank has had which function
    Traffic traffic;
    std::thread post;

    void run_post(const std::string& build) {
        const int count = static_cast<int>(ranks.size());
        std::string odd;
        Patience patience;
        for (int greeted = 1; greeted < count && !interrupted();) {
            const auto letter = transport->receive();
            if (!letter) {
                std::this_thread::sleep_for(patience.next());
                continue;
            }
            const Json hello = Json::from_cbor(letter->bytes);
            if (hello.at(1) != build) {
                odd = hello.at(1).get<std::string>();
            }
            const std::scoped_lock lock(mutex);
            ranks[static_cast<std::size_t>(letter->rank)].offered = hello.at(2);
            ++greeted;
        }
        if (!odd.empty()) {
            for (int rank = 1; rank < count; ++rank) {
                transport->send(rank, packed({"home", "refused"}));
            }
            throw std::runtime_error(
                fmt::format("the processes of the job are not of one build: \"{}\" and \"{}\"", build, odd));
        }
        {
            const std::scoped_lock lock(mutex);
            joined = true;
        }
        told.notify_all();
        std::unique_lock lock(mutex);
        while (!leaving) {
            bool quiet = true;
            while (!out.empty()) {
                auto [rank, bytes] = std::move(out.front());
                out.pop_front();
                traffic.bytes_out += static_cast<std::int64_t>(bytes.size());
                lock.unlock();
                transport->send(rank, std::move(bytes));
                lock.lock();
                quiet = false;
            }
            lock.unlock();
            auto letter = transport->receive();
            lock.lock();
            if (letter) {
                quiet = false;
                traffic.bytes_in += static_cast<std::int64_t>(letter->bytes.size());
                Json json = Json::from_cbor(letter->bytes);
                traffic.cpu_seconds += json.at(2).get<double>();
                const auto ticket = tickets.find(json.at(1).get<std::int64_t>());
                if (ticket->second.abandoned) {
                    tickets.erase(ticket);
                } else {
                    ticket->second.tell = std::move(json.at(3));
                    told.notify_all();
                }
            }
            traffic.post_cpu_seconds = 1e-9 * static_cast<double>(thread_cpu_ns());
            if (quiet) {
                post_came.wait_for(lock, patience.next());
            } else {
                patience.letter_came();
            }
        }
        lock.unlock();
        for (int rank = 1; rank < count; ++rank) {
            transport->send(rank, packed(Json::array({"home"})));
        }
    }

    static int capacity(const Rank& rank, int asked) {
        return asked > 0 ? std::min(asked, rank.offered) : rank.offered;
    }

    // A thread of some process: of this one first, it needs no post.
    std::size_t take(int own_threads, int asked) {
        std::unique_lock lock(mutex);
        for (;;) {
            for (std::size_t i = 0; i < ranks.size(); ++i) {
                if (ranks[i].in_use < (i == 0 ? own_threads : capacity(ranks[i], asked))) {
                    ++ranks[i].in_use;
                    return i;
                }
            }
            slot_came.wait(lock);
        }
    }
    void give_back(std::size_t rank) {
        {
            const std::scoped_lock lock(mutex);
            --ranks[rank].in_use;
        }
        slot_came.notify_one();
    }

    // at_once: evaluate_many() is meant, else evaluate() at the one point.
    Json ask(std::size_t rank, const std::string& key, const std::string& description,
             std::span<const std::vector<double>> of_points, bool with_jacobian, bool at_once) {
        const std::vector<std::vector<double>> points(of_points.begin(), of_points.end());
        std::unique_lock lock(mutex);
        const std::int64_t number = next_ticket++;
        auto& has = sent.try_emplace(key, std::vector<char>(ranks.size(), 0)).first->second;
        bool send_description = has[rank] == 0;
        for (;;) {
            has[rank] = 1;
            Ticket& ticket = tickets[number];
            out.emplace_back(static_cast<int>(rank), packed({"ask", number, key, points, with_jacobian,
                                                             send_description ? description : "", at_once}));
            ++traffic.requests;
            post_came.notify_one();
            std::optional<std::chrono::steady_clock::time_point> end;
            while (!ticket.tell && !failure) {
                told.wait_for(lock, 200ms);
                if (interrupted() && !end) { // what is nearly finished is waited for
                    end = std::chrono::steady_clock::now() + 500ms;
                }
                if (end && std::chrono::steady_clock::now() > *end) {
                    ticket.abandoned = true;
                    throw Interrupted();
                }
            }
            if (failure) {
                std::rethrow_exception(failure);
            }
            Json tell = std::move(*ticket.tell);
            tickets.erase(number);
            if (tell.at(0) != Kind::unknown_function) {
                return tell;
            }
            send_description = true;
        }
    }
};

namespace {

std::atomic<Cluster*> the_cluster{nullptr};

} // namespace

Cluster* Cluster::current() {
    return the_cluster;
}

Cluster::Cluster(std::unique_ptr<Transport> transport, const std::string& build)
    : implementation_(std::make_unique<Implementation>()) {
    Implementation& m = *implementation_;
    m.ranks.resize(static_cast<std::size_t>(transport->ranks()));
    m.ranks[0].offered = threads_of_process(*transport);
    m.transport = std::move(transport);
    m.post = std::thread([&m, build] {
        try {
            m.run_post(build);
        } catch (...) {
            const std::scoped_lock lock(m.mutex);
            m.failure = std::current_exception();
            m.told.notify_all();
        }
    });
    std::unique_lock lock(m.mutex);
    m.told.wait(lock, [&] { return m.joined || m.failure; });
    if (m.failure) {
        lock.unlock();
        m.post.join();
        std::rethrow_exception(m.failure);
    }
    the_cluster = this;
}

Cluster::~Cluster() {
    the_cluster = nullptr;
    Implementation& m = *implementation_;
    {
        const std::scoped_lock lock(m.mutex);
        m.leaving = true;
    }
    m.post_came.notify_all();
    m.post.join();
}

int Cluster::own_threads() const {
    return implementation_->ranks[0].offered;
}

int Cluster::threads(int asked) const {
    int sum = 0;
    for (std::size_t i = 1; i < implementation_->ranks.size(); ++i) {
        sum += Implementation::capacity(implementation_->ranks[i], asked);
    }
    return sum;
}

Cluster::Traffic Cluster::traffic() const {
    const std::scoped_lock lock(implementation_->mutex);
    return implementation_->traffic;
}

std::shared_ptr<const ForwardFunction> Cluster::spread(std::shared_ptr<const ForwardFunction> function, int own_threads,
                                                       int asked) {
    class Spread final : public ForwardFunction {
    public:
        Spread(std::shared_ptr<const ForwardFunction> function, std::string description, Implementation& cluster,
               int own_threads, int asked)
            : own_(std::move(function)),
              description_(std::move(description)),
              key_(data::hash_of(description_)),
              cluster_(cluster),
              own_threads_(own_threads),
              asked_(asked) {}

        struct Own : Workspace {}; // the real ones belong to those that compute
        std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Own>(); }

        Answer evaluate(std::span<const double> values, bool with_jacobian, Workspace&) const override {
            const Slot slot(*this);
            if (slot.rank == 0) {
                return own_.evaluate(values, with_jacobian);
            }
            const std::vector<double> point(values.begin(), values.end());
            return std::move(there(slot.rank, {&point, 1}, with_jacobian, false).at(0));
        }
        std::vector<Answer> evaluate_many(std::span<const std::vector<double>> points, bool with_jacobian,
                                          Workspace&) const override {
            const Slot slot(*this);
            return slot.rank == 0 ? own_.evaluate_many(points, with_jacobian)
                                  : there(slot.rank, points, with_jacobian, true);
        }
        std::size_t lanes() const override { return own_.lanes(); }

    private:
        // A thread of some process, as long as it is there.
        struct Slot {
            explicit Slot(const Spread& spread)
                : cluster(spread.cluster_),
                  rank(cluster.take(spread.own_threads_, spread.asked_)) {}
            ~Slot() { cluster.give_back(rank); }
            Slot(const Slot&) = delete;
            Slot& operator=(const Slot&) = delete;
            Implementation& cluster;
            std::size_t rank;
        };
        std::vector<Answer> there(std::size_t rank, std::span<const std::vector<double>> points, bool with_jacobian,
                                  bool at_once) const {
            const Json tell = cluster_.ask(rank, key_, description_, points, with_jacobian, at_once);
            switch (tell.at(0).get<Kind>()) {
            case Kind::answers: break;
            case Kind::no_memory: throw std::bad_alloc();
            default:
                throw std::runtime_error(fmt::format("process {} of the job: {}", rank, tell.at(1).get<std::string>()));
            }
            std::vector<Answer> answers;
            for (const Json& answer : tell.at(1)) {
                answers.push_back(answer.size() == 1 ? Answer(prediction_of(answer.at(0)))
                                                     : Answer(pave::Failure{answer.at(0).get<pave::Status>(),
                                                                            answer.at(1).get<std::string>()}));
            }
            return answers;
        }

        mutable Pooled own_;
        std::string description_;
        std::string key_;
        Implementation& cluster_;
        int own_threads_;
        int asked_;
    };
    std::string description = function->description();
    if (description.empty()) {
        return function;
    }
    return std::make_shared<Spread>(std::move(function), std::move(description), *implementation_, own_threads, asked);
}

} // namespace explore::run
