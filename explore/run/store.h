// The run store: every finished evaluation in an SQLite file, as it comes.
#pragma once

#include "data/csv.h"
#include "problem/problem.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace explore::run {

// Which evaluation of a run: number `number` of the design, or of the local search from start `start`.
struct RunNumber {
    int start = -1; // -1: the design
    int number = 0;
    friend bool operator<(const RunNumber& a, const RunNumber& b) {
        return a.start != b.start ? a.start < b.start : a.number < b.number;
    }
};

// The task of one command. Equal keys: the same run, continued.
struct RunKey {
    std::string command;
    std::string study_hash;
    std::string settings; // everything else that fixes the evaluations
    bool operator==(const RunKey&) const = default;
};

// The description that a run keeps of itself.
struct RunHeader {
    int id = 0;
    RunKey key;
    std::string version;                 // of the program that began it
    std::vector<std::string> parameters; // names
    std::vector<std::string> responses;  // names with units
    std::vector<double> response_to_si;
};

// One process's part of a store.
struct Session {
    std::string version{};                // of the program
    std::string libraries{};              // whose versions decide digits
    std::vector<std::string> arguments{}; // of the command line
    std::string directory{};              // that it was started in
    int threads = 0;
    std::string began{};          // UTC, ISO 8601; filled in by the store
    double seconds = 0.0;         // up to the last evaluation; by the store
    std::int64_t evaluations = 0; // that it computed, new to the store or not; by the store
    std::int64_t id = 0;          // by the store
};

// One file. All functions may be called from any thread. Throws pave::Error for a file that is not a store, is of
// another version, or cannot be written.
class Store {
public:
    static constexpr int format_version = 3;

    // Opens DIR/run.sqlite to read what is there.
    explicit Store(const std::string& folder);
    // Opens it to go on in it; makes folder and file when they are not there.
    Store(const std::string& folder, Session session);
    ~Store();

    // The run with this key: the one begun before, or a new one. It becomes the newest of the store.
    int begin(const RunHeader& header);
    // Every run of the store, the one used last first. Never empty (throws).
    std::vector<RunHeader> runs() const;

    // Keeps an evaluation for good: when this returns, ending the process loses nothing of it.
    // Not what a limit of time ended: the next attempt may have an answer. Those are counted.
    void put(int run, RunNumber number, const problem::Evaluation& evaluation);
    std::size_t over_time() const;
    // The evaluations of the run in [first, last], in run order.
    std::map<RunNumber, problem::Evaluation> get(int run, RunNumber first, RunNumber last) const;
    void each(int run, const std::function<void(RunNumber, const problem::Evaluation&)>& visit) const;

    // In the order they began.
    std::vector<Session> sessions() const;

    // The files that this session reads: kept with it from its first evaluation on. study_hash: of the study among
    // them, whose file is the first; may be empty.
    void keep_inputs(const std::string& study_hash, const std::vector<data::InputFile>& files);
    // Those of a session; none: a store of a program that did not keep them.
    std::vector<data::InputFile> inputs(std::int64_t session) const;
    // The text of a study with this hash, as it was last run; nothing: not kept.
    std::optional<std::string> study_text(const std::string& study_hash) const;

    // Whole results, by name ("result" holds the JSON a command printed).
    void put_result(int run, const std::string& json);

private:
    Store(const std::string& folder, std::optional<Session> session);
    void count_evaluation();

    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
    mutable std::mutex mutex_;
    std::size_t over_time_ = 0;
};

} // namespace explore::run
