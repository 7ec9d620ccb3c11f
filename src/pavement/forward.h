// The forward run: a section under its loads, read by its sensors.
#pragma once

#include "base/outcome.h"
#include "fe/statistics.h"
#include "pavement/parameter.h"
#include "pavement/section.h"

#include <memory>
#include <span>

namespace pave::pavement {

class LoadModel; // load_model.h
struct Fields;   // fields.h

struct Response {
    std::vector<double> values; // one a sensor, SI, signs of Quantity; not a number: of a load left out
    Eigen::MatrixXd jacobian;   // sensors x parameters, SI per file unit of the parameter
    fe::Statistics statistics;  // sums over the loads; residual: the largest
    std::vector<std::string> warnings;
    std::vector<double> errors; // of reduced models: estimates of |error| of the values; empty: none are made
};

// Throws Error at `place` when no parameter value can make the sensor of the case readable: outside the mesh, a gauge
// length where there is none.
void check_sensor(const Case& c, const Sensor& sensor, const Place& place);

// Throws Error at `place` when a layer cannot be followed by the integration of the case.
void check_integration(const Case& c, const Place& place);

// Throws Error at `place` where the patches of a load overlap, it does not fit into the mesh, or is a gear on layers
// that are not linear.
void check_load(const Case& c, int load, const Place& place);

// Construction throws Error for what no parameter value can mend.
class ForwardModel {
public:
    // nominal: its geometry fixes the mesh; other thicknesses and radii move the lines of that mesh.
    // loads: which of them to compute; empty: all.
    explicit ForwardModel(Case nominal, const std::vector<bool>& loads = {});
    // With models of the loads made elsewhere, that stand for those of the finite element model; none: the load is left
    // out.
    ForwardModel(Case nominal, std::vector<std::shared_ptr<const LoadModel>> models);

    // Meshes and factors of one thread. A workspace makes a run faster, never different.
    class Workspace;
    struct WorkspaceDeleter {
        void operator()(Workspace* workspace) const;
    };
    using WorkspacePointer = std::unique_ptr<Workspace, WorkspaceDeleter>;
    WorkspacePointer make_workspace() const;

    // The response at `values`, a case that differs from the nominal one in numbers only; with its derivatives by
    // `parameters`: exact for the discrete algorithm, but by differences of readings in the same run for effects that
    // move sensors alone, and by differences of runs for geometry, of a layer or of an effect, where fields, springs or
    // inertia go with it. Effects that are varied must be `present`. Pure: same input, same bits.
    Outcome<Response> run(const Case& values, const std::vector<Parameter>& parameters, Workspace& workspace) const;

    // The same at many values, in the order of these: as run(), but for rounding where runs go together in lanes of the
    // processor's vectors (fe/batch_solver.h). Whether a run does, and its bits, depend on it alone.
    std::vector<Outcome<Response>> run_many(std::span<const Case> values, const std::vector<Parameter>& parameters,
                                            Workspace& workspace) const;
    // How many go together for about the price of one; 1: none do.
    int lanes() const;

    // The state of the run at `values` under a load, at rest; of a load that nothing reads too.
    Outcome<Fields> fields(const Case& values, int load) const;

    const Case& nominal() const { return nominal_; }
    // Unknowns of the finite element model of each load, 0 where nothing is read.
    std::vector<int> unknowns() const;
    // The cost of a run, from the sizes of its meshes; a machine may differ from these estimates by a factor of two.
    struct Cost {
        double memory = 0.0; // bytes of a workspace once every load was run, of three-dimensional models: all else is
                             // small beside them
        double seconds = 0.0;
        double derivative = 0.0; // s, what each derivative adds
    };
    Cost cost() const;

private:
    // How derivatives are made at some values: sensors that are read in passing, where a parameter moves sensors alone;
    // runs again, where one does not know its derivative.
    struct Plan;
    Plan plan(const Case& values, const std::vector<Parameter>& parameters) const;
    // response: at `values`. Of the sensors of these loads; the others' entries mean nothing.
    Outcome<Eigen::VectorXd> difference_quotient(const Case& values, const Response& response,
                                                 const Parameter& parameter, const std::vector<bool>& loads,
                                                 Workspace& workspace) const;
    // loads: which of them to run; empty: all. A derivative that a load does not have is zero there.
    Outcome<Response> run_exact(const Case& values, const std::vector<Parameter>& parameters,
                                const std::vector<bool>& loads, const Plan& plan, Workspace& workspace) const;

    Case nominal_;
    std::vector<std::shared_ptr<const LoadModel>> models_; // of each load; none where nothing is read on its path
    std::vector<int> path_of_;                             // of each load: the one whose model reads it
};

} // namespace pave::pavement
