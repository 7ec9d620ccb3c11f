// The share of one load in a response: its run made ready, and its readings taken in.
#pragma once

#include "pavement/forward.h"
#include "pavement/load_model.h"

namespace pave::pavement {

// A sensor that is read in passing, for a derivative by what moves sensors alone.
struct MovedSensor {
    std::size_t parameter, row; // of the jacobian
    Sensor sensor;
    double weight; // of its reading in the derivative
};

class LoadRun {
public:
    // At `values`, differentiated by those of `parameters` that the load knows the derivative by. moved: read too. An
    // answer without a run: why it has none.
    static Outcome<LoadRun> prepare(const Case& values, int load, const LoadModel& model,
                                    const std::vector<Parameter>& parameters, const std::vector<MovedSensor>& moved);

    LoadModel::Run run() const { return {&case_, &layers_, &variations_}; }
    Outcome<LoadModel::Reading> read(const LoadModel& model, LoadModel::Workspace& workspace) const;
    // Whether it goes with others (LoadModel::run_together).
    bool goes_with_others(const LoadModel& model) const { return motions_.empty() && model.goes_with_others(run()); }

    // Takes the readings into those of the loads before; of the sensors that are read on the path of this one.
    void add(const LoadModel::Reading& reading, const std::vector<int>& path_of, Response& response) const;
    // A reason with the name of the load before it.
    Failure named(const Failure& failure) const;

private:
    LoadRun() = default;

    int load_ = 0;
    Case case_;
    std::size_t sensors_ = 0; // of the values; those that are moved follow
    std::vector<MovedSensor> moved_;
    std::vector<fe::LayerMaterial> layers_;
    std::vector<fe::Variation> variations_; // each once
    std::vector<Neighbours> motions_;
    // Of each parameter.
    std::vector<Derivative> derivatives_;
    std::vector<std::vector<std::pair<Eigen::Index, double>>> shares_; // variation, factor
};

// Why a load cannot meet this case, its effects applied, or "".
std::string why_impossible(const Case& c, int load);

// A response without readings yet.
Response empty_response(const Case& values, std::size_t parameters);
// Warnings by the figures of all loads.
void add_warnings(const Case& values, Response& response);

} // namespace pave::pavement
