// A run store whose rows hold anything: the input gives the cells of one run and of its evaluations.
#include "run/store.h"
#include "target.h"

#include <SQLiteCpp/SQLiteCpp.h>

namespace {

// The input as a list of cells: each two bytes of length, then as many bytes.
class Cells {
public:
    explicit Cells(std::string_view rest) : rest_(rest) {}
    bool more() const { return !rest_.empty(); }
    std::string next() {
        const std::size_t wanted =
            rest_.size() < 2 ? 0 : static_cast<unsigned char>(rest_[0]) * 256U + static_cast<unsigned char>(rest_[1]);
        rest_.remove_prefix(std::min<std::size_t>(2, rest_.size()));
        const std::string cell(rest_.substr(0, wanted));
        rest_.remove_prefix(std::min(wanted, rest_.size()));
        return cell;
    }

private:
    std::string_view rest_;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Folder folder;
    static const bool made = [] {
        const explore::run::Store store(folder.path(""), explore::run::Session{});
        return true;
    }();
    (void)made;
    {
        SQLite::Database database(folder.path("run.sqlite"), SQLite::OPEN_READWRITE);
        database.exec("PRAGMA synchronous = OFF; DELETE FROM evaluation; DELETE FROM run; DELETE FROM session");
        Cells cells(fuzz::text_of(data, size));
        SQLite::Statement run(database, "INSERT INTO run VALUES (1, ?, ?, ?, ?, ?, 0, NULL)");
        for (int i = 1; i <= 5; ++i) {
            run.bind(i, cells.next());
        }
        run.exec();
        SQLite::Statement session(database, "INSERT INTO session VALUES (1, ?, ?, ?, ?, ?, ?, 0, 0)");
        for (int i = 1; i <= 6; ++i) {
            session.bind(i, cells.next());
        }
        session.exec();
        for (int number = 0; cells.more() && number < 4; ++number) {
            SQLite::Statement row(database, "INSERT INTO evaluation VALUES (1, -1, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
            row.bind(1, number);
            const std::string status = cells.next();
            row.bind(2, status.empty() ? 0 : static_cast<signed char>(status[0]));
            row.bind(3, cells.next());
            for (int i = 4; i <= 6; ++i) {
                const std::string blob = cells.next();
                row.bind(i, static_cast<const void*>(blob.data()), static_cast<int>(blob.size()));
            }
            row.bind(7, cells.next());
            row.bind(8, 1.0);
            row.bind(9, number % 2); // the model in place of the reduced one
            row.exec();
        }
    }
    fuzz::expect_message([&] {
        const explore::run::Store store(folder.path(""));
        for (const auto& run : store.runs()) {
            store.each(run.id, [&](explore::run::RunNumber, const explore::problem::Evaluation& e) {
                // What every reader of a store relies on.
                if (e.parameters.size() != run.parameters.size() ||
                    (e.converged() && e.responses.size() != run.responses.size())) {
                    std::abort();
                }
            });
        }
        store.sessions();
    });
    return 0;
}
