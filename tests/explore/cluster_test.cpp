// Processes that compute for one, as threads of this one that exchange letters through queues.
#include "run/cluster.h"

#include <deque>
#include <gtest/gtest.h>
#include <mutex>
#include <new>
#include <stdexcept>
#include <thread>

using namespace explore;

namespace {

struct PostOffice {
    std::mutex mutex;
    std::vector<std::deque<run::Letter>> boxes;
};

class Queues final : public run::Transport {
public:
    Queues(std::shared_ptr<PostOffice> office, int rank) : office_(std::move(office)), rank_(rank) {}
    int rank() const override { return rank_; }
    int ranks() const override { return static_cast<int>(office_->boxes.size()); }
    int ranks_of_this_machine() const override { return ranks(); }
    void send(int rank, std::string bytes) override {
        const std::scoped_lock lock(office_->mutex);
        office_->boxes[static_cast<std::size_t>(rank)].push_back({rank_, std::move(bytes)});
    }
    std::optional<run::Letter> receive() override {
        const std::scoped_lock lock(office_->mutex);
        auto& box = office_->boxes[static_cast<std::size_t>(rank_)];
        if (box.empty()) {
            return std::nullopt;
        }
        run::Letter letter = std::move(box.front());
        box.pop_front();
        return letter;
    }

private:
    std::shared_ptr<PostOffice> office_;
    int rank_;
};

// a x + 1 with a of its description; x < 0 has no answer, x = 1000 no memory, x = 2000 is a mistake in the program.
class Line final : public problem::ForwardFunction {
public:
    explicit Line(int a) : a_(a) {}
    std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
    pave::Outcome<problem::Prediction> evaluate(std::span<const double> p, bool with_jacobian,
                                                Workspace&) const override {
        if (p[0] < 0.0) {
            return pave::Failure{pave::Status::invalid_parameters, "below zero"};
        }
        if (p[0] == 1000.0) {
            throw std::bad_alloc();
        }
        if (p[0] == 2000.0) {
            throw std::logic_error("out of thin air");
        }
        problem::Prediction out;
        out.responses = {a_ * p[0] + 1.0, std::numeric_limits<double>::quiet_NaN()};
        out.warnings = {"a warning"};
        if (with_jacobian) {
            out.jacobian = Eigen::MatrixXd::Constant(2, 1, 1.0 / 3.0 * a_);
        }
        return out;
    }
    std::string description() const override { return std::to_string(a_); }

private:
    int a_;
};

// Rank 0 and `others` that serve it, as long as it lives.
struct Job {
    explicit Job(int others, const std::string& other_build = "build") {
        auto office = std::make_shared<PostOffice>();
        office->boxes.resize(static_cast<std::size_t>(others) + 1);
        for (int rank = 1; rank <= others; ++rank) {
            threads.emplace_back([this, office, rank, other_build] {
                Queues transport(office, rank);
                try {
                    run::serve(transport, other_build, [this](const std::string& description) {
                        ++made;
                        return std::make_shared<Line>(std::stoi(description));
                    });
                } catch (const std::runtime_error&) {
                    ++refused;
                }
            });
        }
        try {
            cluster = std::make_unique<run::Cluster>(std::make_unique<Queues>(office, 0), "build");
        } catch (...) {
            end();
            throw;
        }
    }
    ~Job() { end(); }
    void end() {
        cluster.reset();
        for (auto& t : threads) {
            t.join();
        }
        threads.clear();
    }
    std::atomic<int> made{0};
    static inline std::atomic<int> refused{0};
    std::vector<std::thread> threads;
    std::unique_ptr<run::Cluster> cluster;
};

pave::Outcome<problem::Prediction> ask(const problem::ForwardFunction& function, double x, bool jacobian = false) {
    return function.evaluate(std::vector<double>{x}, jacobian, *function.make_workspace());
}

} // namespace

TEST(Cluster, GivesTheAnswersOfTheFunctionWhoeverComputes) {
    Job job(2);
    for (const int own_threads : {0, 1}) { // 0: everything is computed elsewhere
        const auto line = job.cluster->spread(std::make_shared<Line>(7), own_threads, 0);
        std::vector<std::thread> askers;
        askers.reserve(6);
        std::atomic<int> wrong{0};
        for (int t = 0; t < 6; ++t) {
            askers.emplace_back([&, t] {
                for (int i = 0; i < 50; ++i) {
                    const double x = 0.1 * i + t;
                    const auto answer = ask(*line, x, i % 2 == 0);
                    const bool right = answer && answer->responses[0] == 7 * x + 1.0 &&
                                       std::isnan(answer->responses[1]) && answer->warnings.size() == 1 &&
                                       answer->jacobian.rows() == (i % 2 == 0 ? 2 : 0) &&
                                       (i % 2 != 0 || answer->jacobian(1, 0) == 1.0 / 3.0 * 7);
                    wrong += right ? 0 : 1;
                }
            });
        }
        for (auto& asker : askers) {
            asker.join();
        }
        EXPECT_EQ(wrong, 0);
    }
    EXPECT_GE(job.cluster->traffic().requests, 300);
    EXPECT_LE(job.made, 2 * job.cluster->threads(0)) << "a function is made once a process, or nearly";
}

TEST(Cluster, PassesOnWhatWentWrong) {
    Job job(1);
    const auto line = job.cluster->spread(std::make_shared<Line>(2), 0, 0);
    const auto answer = ask(*line, -1.0);
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.status(), pave::Status::invalid_parameters);
    EXPECT_EQ(answer.failure().reason, "below zero");
    EXPECT_THROW(ask(*line, 1000.0), std::bad_alloc);
    EXPECT_THROW(ask(*line, 2000.0), std::runtime_error);
    EXPECT_TRUE(ask(*line, 1.0));
}

TEST(Cluster, SendsAFunctionAgainToAProcessThatHasForgottenIt) {
    Job job(1);
    for (int round = 0; round < 2; ++round) {
        for (int a = 0; a < 40; ++a) {
            const auto line = job.cluster->spread(std::make_shared<Line>(a), 0, 1);
            EXPECT_EQ(ask(*line, 3.0)->responses[0], 3.0 * a + 1.0);
        }
    }
}

TEST(Cluster, RefusesProcessesOfAnotherBuild) {
    Job::refused = 0;
    EXPECT_THROW(Job(2, "another build"), std::runtime_error);
    EXPECT_EQ(Job::refused, 2);
}
