#include "run/store_merge.h"

#include "base/error.h"
#include "run/store_difference.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <set>
#include <sstream>
#include <unistd.h>

namespace explore::run {
namespace {

namespace fs = std::filesystem;

std::string file_in(const std::string& folder) {
    return (fs::path(folder) / "run.sqlite").string();
}

// SQLite's own words, as a complaint about the file.
template <class F>
auto guarded(const std::string& file, F f) {
    try {
        return f();
    } catch (const SQLite::Exception& error) {
        throw pave::Error({.file = file}, "the run store cannot be written", error.what(),
                          "a folder that can be written, and that no command is working in");
    }
}

std::set<std::string> words_of(const SQLite::Database& database, const std::string& select) {
    std::set<std::string> words;
    SQLite::Statement row(database, select);
    while (row.executeStep()) {
        words.insert(row.getColumn(0).getString());
    }
    return words;
}

std::vector<std::string> sorted(const std::set<std::string>& words) {
    return {words.begin(), words.end()};
}

// The studies that a store was begun for, by hash: as they were read, and as they were run.
std::set<std::string> studies_of(const SQLite::Database& database, const std::string& schema) {
    return words_of(database, fmt::format("SELECT study_hash FROM {0}.input WHERE study_hash <> '' "
                                          "UNION SELECT study_hash FROM {0}.run",
                                          schema));
}

// The newest study's file and text; nothing: a store that kept none.
std::optional<std::pair<std::string, std::string>> newest_study(const SQLite::Database& database,
                                                                const std::string& schema) {
    SQLite::Statement row(database, fmt::format("SELECT path, bytes FROM {0}.input JOIN {0}.content ON content = hash "
                                                "WHERE study_hash <> '' ORDER BY session DESC, number",
                                                schema));
    if (!row.executeStep()) {
        return std::nullopt;
    }
    return std::pair(fs::path(row.getColumn(0).getString()).filename().string(), row.getColumn(1).getString());
}

// Why two studies are not one, as far as their files tell.
std::string how_studies_differ(const SQLite::Database& database) {
    const auto first = newest_study(database, "main");
    const auto second = newest_study(database, "other");
    if (!first || !second) {
        return "another study or other readings";
    }
    std::istringstream a(first->second);
    std::istringstream b(second->second);
    for (int line = 1; a || b; ++line) {
        std::string in_first;
        std::string in_second;
        std::getline(a, in_first);
        std::getline(b, in_second);
        if (in_first != in_second) {
            return fmt::format("{} and {} differ first in line {}: \"{}\" and \"{}\"", first->first, second->first,
                               line, in_first, in_second);
        }
    }
    return fmt::format("the readings of {} differ", first->first);
}

void refuse_strangers(const SQLite::Database& database, const std::string& first, const std::string& second) {
    const auto here = studies_of(database, "main");
    const auto there = studies_of(database, "other");
    if (std::none_of(there.begin(), there.end(), [&](const std::string& hash) { return here.contains(hash); })) {
        throw pave::Error({.file = second}, "this is a run of another study than " + first,
                          how_studies_differ(database), "two runs of one study with the same readings");
    }
    const auto versions = words_of(database, "SELECT version FROM main.run UNION SELECT version FROM main.session "
                                             "UNION SELECT version FROM other.run UNION SELECT version FROM "
                                             "other.session");
    if (versions.size() > 1) {
        throw pave::Error({.file = second}, "the two runs were computed by different versions of the program",
                          pave::join(sorted(versions)), "runs of one version");
    }
}

// Where evaluations of both that are of one point stand.
struct Twin {
    RunNumber first, second;
};

// The part of the second's run that has no twin, and under which number it is to be kept.
struct Plan {
    std::vector<Twin> added;
    std::size_t compared = 0;
};

Plan plan_of(const Store& here, const RunHeader& ours, const Store& there, const RunHeader& theirs,
             const std::string& first, const std::string& second) {
    const auto refuse = [&](const std::string& difference) {
        throw pave::Error({.file = second}, "the two runs differ where both have computed",
                          fmt::format("{} (first: {})", difference, first),
                          "runs whose common points have the same bits; nothing was merged");
    };
    if (ours.parameters != theirs.parameters || ours.responses != theirs.responses ||
        ours.response_to_si != theirs.response_to_si) {
        refuse(ours.key.command + ": other parameters or readings");
    }
    std::map<RunNumber, problem::Evaluation> known;
    std::map<std::pair<int, std::vector<double>>, RunNumber> by_point;
    std::map<int, int> next; // of each search
    here.each(ours.id, [&](RunNumber n, const problem::Evaluation& e) {
        by_point.try_emplace({n.start, e.parameters}, n);
        known.emplace(n, e);
        next[n.start] = n.number + 1; // in order
    });
    Plan plan;
    std::vector<RunNumber> displaced;
    there.each(theirs.id, [&](RunNumber n, const problem::Evaluation& e) {
        auto same = known.find(n);
        if (n.start >= 0 && (same == known.end() || same->second.parameters != e.parameters)) {
            const auto at = by_point.find({n.start, e.parameters});
            if (at == by_point.end()) {
                if (same == known.end()) {
                    plan.added.push_back({n, n});
                    next[n.start] = std::max(next[n.start], n.number + 1);
                } else {
                    displaced.push_back(n);
                }
                return;
            }
            same = known.find(at->second);
        }
        if (same == known.end()) {
            plan.added.push_back({n, n});
            return;
        }
        const bool derivatives_in_both = same->second.jacobian.size() > 0 && e.jacobian.size() > 0;
        const bool one_has_derivatives = !derivatives_in_both && same->second.jacobian.size() != e.jacobian.size();
        if (one_has_derivatives && n.start >= 0) { // requested first without, then with them
            if (e.jacobian.size() > 0) {
                displaced.push_back(n);
            }
            return;
        }
        if (const std::string words = difference_of(theirs, n, same->second, e, {"here", "there"}); !words.empty()) {
            refuse(words);
        }
        ++plan.compared;
    });
    for (const RunNumber n : displaced) {
        plan.added.push_back({{n.start, next[n.start]++}, n});
    }
    return plan;
}

class Merging {
public:
    explicit Merging(SQLite::Database& database)
        : database_(database),
          add_(database,
               "INSERT INTO main.evaluation (run, start, number, status, reason, parameters, responses, jacobian, "
               "warnings, misfit, in_place_of_reduced) SELECT ?, ?, ?, status, reason, parameters, responses, "
               "jacobian, warnings, misfit, in_place_of_reduced FROM other.evaluation WHERE run = ? AND start = ? "
               "AND number = ?") {}

    void add(int ours, int theirs, const std::vector<Twin>& evaluations) {
        for (const Twin& e : evaluations) {
            add_.reset();
            int at = 0;
            for (const int value : {ours, e.first.start, e.first.number, theirs, e.second.start, e.second.number}) {
                add_.bind(++at, value);
            }
            add_.exec();
        }
    }

    // A run that only the second has; its evaluations.
    std::size_t add_run(int theirs) {
        const auto run = [&](const std::string& text, const auto&... ids) {
            SQLite::Statement statement(database_, text);
            int at = 0;
            (statement.bind(++at, ids), ...);
            return statement.exec();
        };
        run("INSERT INTO main.run (command, study_hash, settings, version, header, used, result) SELECT command, "
            "study_hash, settings, version, header, (SELECT coalesce(max(used), 0) + 1 FROM main.run), result FROM "
            "other.run WHERE id = ?",
            theirs);
        return static_cast<std::size_t>(
            run("INSERT INTO main.evaluation (run, start, number, status, reason, parameters, responses, jacobian, "
                "warnings, misfit, in_place_of_reduced) SELECT ?, start, number, status, reason, parameters, "
                "responses, jacobian, warnings, misfit, in_place_of_reduced FROM other.evaluation WHERE run = ?",
                database_.getLastInsertRowid(), theirs));
    }

    // The sessions of the second, each with its files. One that both have (a copy was continued) is that of the later.
    void add_sessions() {
        database_.exec("INSERT OR IGNORE INTO main.content (hash, bytes) SELECT hash, bytes FROM other.content");
        SQLite::Statement session(database_, "SELECT id, version, libraries, arguments, directory, threads, began, "
                                             "seconds, evaluations FROM other.session ORDER BY id");
        while (session.executeStep()) {
            SQLite::Statement known(database_, "SELECT id FROM main.session WHERE version = ? AND libraries = ? AND "
                                               "arguments = ? AND directory = ? AND threads = ? AND began = ?");
            SQLite::Statement add(database_,
                                  "INSERT INTO main.session (version, libraries, arguments, directory, threads, began, "
                                  "seconds, evaluations) VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
            for (int i = 1; i <= 8; ++i) {
                const SQLite::Column value = session.getColumn(i);
                for (SQLite::Statement* to : {&known, &add}) {
                    if (to == &known && i > 6) {
                        continue;
                    }
                    if (value.isInteger()) {
                        to->bind(i, value.getInt64());
                    } else if (value.isFloat()) {
                        to->bind(i, value.getDouble());
                    } else {
                        to->bind(i, value.getString());
                    }
                }
            }
            std::int64_t ours = 0;
            if (known.executeStep()) {
                ours = known.getColumn(0).getInt64();
                SQLite::Statement later(database_, "UPDATE main.session SET seconds = max(seconds, ?), evaluations = "
                                                   "max(evaluations, ?) WHERE id = ?");
                later.bind(1, session.getColumn(7).getDouble());
                later.bind(2, session.getColumn(8).getInt64());
                later.bind(3, ours);
                later.exec();
            } else {
                add.exec();
                ours = database_.getLastInsertRowid();
            }
            SQLite::Statement inputs(database_, "INSERT OR IGNORE INTO main.input (session, number, path, study_hash, "
                                                "content) SELECT ?, number, path, study_hash, content FROM other.input "
                                                "WHERE session = ?");
            inputs.bind(1, ours);
            inputs.bind(2, session.getColumn(0).getInt64());
            inputs.exec();
        }
    }

private:
    SQLite::Database& database_;
    SQLite::Statement add_;
};

} // namespace

MergeReport merge_stores(const std::string& first, const std::string& second) {
    const Store here(first); // which see to it that both are stores of this format
    const Store there(second);
    const std::string file = file_in(first);
    return guarded(file, [&] {
        SQLite::Database database(file, SQLite::OPEN_READWRITE, 10000);
        SQLite::Statement attach(database, "ATTACH DATABASE ? AS other");
        attach.bind(1, file_in(second));
        attach.exec();
        SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
        refuse_strangers(database, first, second);
        const auto ours = here.runs();
        auto theirs = there.runs();
        std::reverse(theirs.begin(), theirs.end()); // the one used last is added last
        MergeReport report;
        Merging merging(database);
        for (const RunHeader& run : theirs) {
            const auto same =
                std::find_if(ours.begin(), ours.end(), [&](const RunHeader& known) { return known.key == run.key; });
            if (same == ours.end()) {
                report.added += merging.add_run(run.id);
                continue;
            }
            const Plan plan = plan_of(here, *same, there, run, first, second);
            merging.add(same->id, run.id, plan.added);
            report.added += plan.added.size();
            report.compared += plan.compared;
        }
        merging.add_sessions();
        const auto count = [&](const char* table) {
            return static_cast<std::size_t>(
                database.execAndGet(fmt::format("SELECT count(*) FROM main.{}", table)).getInt64());
        };
        report.runs = count("run");
        report.evaluations = count("evaluation");
        const auto libraries = words_of(database, "SELECT libraries FROM main.session");
        report.libraries = libraries.size() > 1 ? pave::join(sorted(libraries), " | ") : "";
        transaction.commit();
        return report;
    });
}

void copy_store(const std::string& folder, const std::string& copy) {
    const Store is_one(folder);
    std::error_code error;
    fs::create_directories(copy, error);
    const std::string part = fmt::format("{}.{}.part", file_in(copy), getpid());
    guarded(file_in(copy), [&] {
        SQLite::Database database(file_in(folder), SQLite::OPEN_READWRITE, 10000);
        SQLite::Statement vacuum(database, "VACUUM INTO ?"); // all that is in the log, too
        vacuum.bind(1, part);
        vacuum.exec();
    });
    fs::rename(part, file_in(copy), error);
    if (error) {
        throw pave::Error({.file = copy}, "the run store cannot be written", error.message(), "another folder (--out)");
    }
}

} // namespace explore::run
