// Models that are the baseline with something added, and fits of them.
#pragma once

#include "run/engine.h"

#include <atomic>
#include <limits>
#include <map>
#include <mutex>

namespace explore::diagnose {

// Something the model may lack: a size that is zero effect at one value.
struct Candidate {
    std::string effect;
    std::string on;                     // what it acts on, in words; empty: what it always acts on
    double null = 0.0;                  // the size that changes nothing, and one that is seen in practice:
    double typical = 0.0;               // unit coordinates of its axis
    std::optional<std::size_t> reading; // the reading (term of the misfit) that it declares wrong
    std::string layer;           // whose stiffness is all that it changes; empty: it changes more, or other things
    bool high_is_limit = false;  // no size beyond its range exists
    bool is_layout = false;      // of the sensors as a whole
    bool is_of_readings = false; // all that it changes is what instruments say
    bool is_of_limit = false;    // the reading is a limit: its error is known on one side alone
    std::vector<std::size_t> scaled{}; // responses that its size multiplies, which is all that it does
    problem::Axis axis{};              // of the size, where it does

    std::string words() const { return effect + (on.empty() ? "" : " (" + on + ")"); }
};

// Where a smooth correction of the model may act, whatever the cause: so many coefficients, each the logarithm of a
// factor at one place, that are numbers of models as sizes of candidates are.
struct Channel {
    std::string name;
    std::string layer;     // empty: of readings
    std::size_t first = 0; // member of the first coefficient, after all candidates
    std::size_t count = 0;
};
// Unit coordinate of a coefficient that corrects nothing: its axis is logarithmic, with its middle at 1.
inline constexpr double no_correction = 0.5;

// The residuals of a model are noise where chance makes as much this often.
inline constexpr double level_noise = 0.05;
// Half of the change of chi2 that a fit leaves undone.
inline constexpr double close_enough = 0.005;

// Indices of candidates and of coefficients, rising; of a channel all or none. The problem of a model has the
// parameters of the baseline, then the sizes of its members.
using Members = std::vector<std::size_t>;

// Residuals to be fitted in place of those of the data.
struct Target {
    Eigen::VectorXd offset;     // added to them; empty: nothing
    std::vector<char> left_out; // of each: whether it does not count; empty: all count
    // Rows (by unit coordinates) that pull them towards a point, in the unit of the residuals; none: nothing pulls.
    Eigen::MatrixXd penalty{};
    Eigen::VectorXd centre{};
};

// Without these of so many residuals.
Target leaving_out(const std::vector<std::size_t>& terms, std::size_t residuals);
// The sum of the squares of those that count.
double counted_sum(const Eigen::VectorXd& residuals, const Target& target);

// The mesh of a model. The coarse mesh is several times quicker. What its responses lack is taken from a point
// where both are known and added to them elsewhere (an additive bridge between models of two fidelities: Alexandrov and
// Lewis 2001): its error is then that of changes, a few per cent of them. It proposes; what an answer rests on is
// computed on the study's own mesh.
enum class Mesh { study, coarse };
using Shift = std::vector<double>; // of responses
// own, coarse: of one point.
Shift shift_between(const problem::Evaluation& own, const problem::Evaluation& coarse);
problem::Evaluation shifted(const problem::Problem& problem, problem::Evaluation coarse, const Shift& shift);

// A fitted model.
struct Model {
    Members members;
    std::vector<double> unit;
    problem::Evaluation evaluation; // with jacobian, unless derivatives were saved
    Eigen::VectorXd residuals;      // those that were fitted, and those left out
    double sum = 0.0;               // of squares of those that count, and of what pulls at the parameters
    Mesh mesh = Mesh::study;
    Eigen::MatrixXd open_rows{}; // beside the jacobian of the residuals (diagnose/open_directions.h)
};

struct FitSettings {
    double enough = 0.0;                           // optimise::SearchSettings
    double secant_below = 0.0;                     // the same; > 0: derivatives are saved
    const problem::Evaluation* at_start = nullptr; // with jacobian; computed if nullptr
    // A sum of squares: a search that leads to nothing lower is given up.
    double worth = std::numeric_limits<double>::infinity();
    const Shift* on_coarse = nullptr; // the fit is on the coarse mesh with this shift; nullptr: on the study's own
};

// Least squares from a point; nothing: no answer there, or it was given up.
std::optional<Model> fit(run::Chain& chain, const problem::Problem& problem, const Members& members,
                         const std::vector<double>& start, const Target& target, const FitSettings& settings);

// Makes problems and engines of models. Those of the baseline are kept, of the others, on each mesh, the one used last:
// a diagnosis makes hundreds, each with meshes and eliminated stiffnesses of its own. All functions may be called from
// any thread.
class Workbench {
public:
    struct Making {
        std::function<problem::Problem(const Members&, Mesh)> problem;
        std::function<int(const Members&, Mesh)> run; // of the store, for the evaluations of a model
        run::Store* store = nullptr;
        int threads = 0;
        std::size_t most_numbers = std::numeric_limits<std::size_t>::max(); // that a problem may have
    };
    explicit Workbench(Making making) : making_(std::move(making)) {}

    std::shared_ptr<const problem::Problem> problem(const Members& members, Mesh mesh = Mesh::study);

    // body(problem, engine); what the engine computed is counted.
    template <class Body>
    auto use(const Members& members, Mesh mesh, const Body& body) {
        const auto own = problem(members, mesh);
        Counted engine(*this, *own, {has_coarse_ ? mesh : Mesh::study, members});
        return body(*own, engine.engine);
    }
    // One chain of evaluations, kept under this start number. False: interrupted.
    bool chain(const Members& members, int start, const std::function<void(const problem::Problem&, run::Chain&)>& body,
               Mesh mesh = Mesh::study);
    // The same of several that go in step (run::Engine::chains), kept under start numbers from `first` on.
    bool chains(const Members& members, int first, std::size_t count,
                const std::function<void(const problem::Problem&, std::size_t i, run::Chain&)>& body,
                Mesh mesh = Mesh::study);

    // Where the coarse mesh has no answer: the study's own in its place from here on.
    void give_up_coarse() { has_coarse_ = false; }
    bool has_coarse() const { return has_coarse_; }

    run::Tally tally() const;
    int threads() const { return making_.threads; }
    std::size_t most_numbers() const { return making_.most_numbers; }

private:
    using Key = std::pair<Mesh, Members>;
    struct Counted {
        Counted(Workbench& bench, const problem::Problem& problem, const Key& key);
        ~Counted();
        Counted(const Counted&) = delete;
        Counted& operator=(const Counted&) = delete;
        Workbench& bench;
        run::Engine engine;
    };

    Making making_;
    mutable std::mutex mutex_;
    std::map<Mesh, std::shared_ptr<const problem::Problem>> baselines_;
    std::map<Key, std::weak_ptr<const problem::Problem>> problems_; // in use somewhere, or recent
    // But the baseline: a model is requested again when it was fitted.
    std::map<Mesh, std::shared_ptr<const problem::Problem>> recent_;
    std::map<Key, int> runs_;
    std::atomic<bool> has_coarse_ = true;
    run::Tally tally_;
};

// A model on the coarse mesh.
struct OnCoarse {
    problem::Evaluation evaluation; // shifted, with jacobian
    Shift shift;
};
// Of a fitted model at its point. number: of the evaluation that is kept.
OnCoarse on_coarse(Workbench& bench, const Model& model, int number);

// fit() in a chain of its own, kept under this number, as exact as a diagnosis needs; nothing: interrupted, too.
// variance: of a residual.
std::optional<Model> fit_from(Workbench& bench, const Members& members, int number, const std::vector<double>& start,
                              double variance, const Target& target, const FitSettings& settings);
// The same of several fits of one model that go in step, kept under numbers from `first` on; all are on the coarse mesh
// (settings.on_coarse), or none is.
struct Start {
    std::vector<double> unit; // empty: there is none, and no fit
    const Target* target = nullptr;
    FitSettings settings{};
};
std::vector<std::optional<Model>> fit_in_step(Workbench& bench, const Members& members, int first,
                                              const std::vector<Start>& starts, double variance);
// Of a fit of which only the residuals are wanted: derivatives are saved near the minimum, where these of the start are
// known everywhere. at_start: may be nullptr.
FitSettings for_residuals(const problem::Evaluation* at_start, double variance);
// Puts the model that was found in place of the best so far where it is lower.
void keep_lower(std::optional<Model>& best, std::optional<Model> found);

} // namespace explore::diagnose
