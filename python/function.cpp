#include "function.h"

#include "base/text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <pybind11/numpy.h>

namespace python {
namespace {

namespace py = pybind11;
using Array = py::array_t<double, py::array::c_style>;

class Function final : public explore::external::Simulator {
public:
    explicit Function(FunctionOf of) : of_(std::move(of)) {}
    Function(const Function&) = delete;
    Function& operator=(const Function&) = delete;
    ~Function() override {
        const py::gil_scoped_acquire lock; // the last to know it may be a thread of a search
        of_.function = py::object();
        of_.jacobian = py::object();
    }

    pave::Outcome<std::vector<double>> run(std::span<const double> values) const override {
        const py::gil_scoped_acquire lock;
        return answer<std::vector<double>>(
            of_.function, values, [](const Array& a) { return std::vector<double>(a.data(), a.data() + a.size()); });
    }

    bool has_jacobian() const override { return !of_.jacobian.is_none(); }

    pave::Outcome<Eigen::MatrixXd> jacobian(std::span<const double> values) const override {
        const py::gil_scoped_acquire lock;
        return answer<Eigen::MatrixXd>(of_.jacobian, values, [&](const Array& a) {
            using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
            return Eigen::MatrixXd(Eigen::Map<const Rows>(a.data(), static_cast<Eigen::Index>(of_.responses),
                                                          static_cast<Eigen::Index>(of_.parameters)));
        });
    }

    std::string description() const override {
        return nlohmann::json{{"type", "function"}, {"identity", of_.identity}}.dump();
    }
    void keep_in(const std::string&) const override {}
    std::string kept_words() const override { return ""; }

private:
    template <class T, class Convert>
    pave::Outcome<T> answer(const py::object& function, std::span<const double> values, const Convert& convert) const {
        try {
            const Array x(static_cast<py::ssize_t>(values.size()), values.data());
            const py::object said = function(x);
            if (py::isinstance<py::str>(said)) {
                constexpr std::size_t longest = 500;
                return pave::Failure{pave::Status::failed, pave::printable(said.cast<std::string>(), longest)};
            }
            return convert(said.cast<Array>());
        } catch (const py::error_already_set& error) { // SystemExit, KeyboardInterrupt
            return pave::Failure{pave::Status::failed, pave::printable(error.what())};
        }
    }

    FunctionOf of_;
};

} // namespace

std::shared_ptr<const explore::external::Simulator> make_simulator(FunctionOf of) {
    return std::make_shared<Function>(std::move(of));
}

} // namespace python
