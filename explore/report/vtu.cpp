#include "report/vtu.h"

#include "base/units.h"
#include "run/files.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <span>
#include <stdexcept>
#include <vector>

namespace explore::report {
namespace {

using pave::pavement::Fields;
namespace unit = pave::unit;

std::string base64(std::span<const std::byte> bytes) {
    static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            group = group << 8U | (k < count ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0U);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += k <= count ? letters[group >> (18U - 6U * k) & 63U] : '=';
        }
    }
    return text;
}

// One array of the file: numbers, so many a tuple, preceded by their length in bytes.
template <class T>
std::string data_array(const char* type, const std::string& name, int components, const std::vector<T>& numbers) {
    static_assert(std::endian::native == std::endian::little);
    const std::uint64_t length = numbers.size() * sizeof(T);
    std::vector<std::byte> bytes(sizeof length + length);
    std::memcpy(bytes.data(), &length, sizeof length);
    std::memcpy(bytes.data() + sizeof length, numbers.data(), length);
    const std::string tuple = components > 1 ? fmt::format(" NumberOfComponents=\"{}\"", components) : "";
    return fmt::format("<DataArray type=\"{}\" Name=\"{}\"{} format=\"binary\">{}</DataArray>\n", type, name, tuple,
                       base64(bytes));
}

std::string real_array(const std::string& name, int components, const Eigen::MatrixXd& values) {
    return data_array("Float64", name, components, std::vector<double>(values.data(), values.data() + values.size()));
}

// Components XX YY ZZ XY YZ XZ of a tensor, compression positive, z upwards, from xx yy zz xz yz xy, tension positive,
// z downwards: the two turns of sign meet in xz and yz. shear: what the shear components are multiplied by.
Eigen::MatrixXd tensor(const Eigen::Matrix<double, 6, Eigen::Dynamic>& v, double shear, double scale) {
    Eigen::MatrixXd t(6, v.cols());
    t << -v.topRows<3>(), -shear * v.row(5), shear * v.row(4), shear * v.row(3);
    return scale * t;
}

// The nodes of an element in the order of the toolkit. Upwards z turns a hexahedron inside out unless its lower face
// comes first.
std::vector<std::int64_t> order_of(int nodes) {
    if (nodes == 8) {
        return {0, 1, 2, 3, 4, 5, 6, 7};
    }
    return {4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19};
}

} // namespace

std::string vtu_text(const Fields& f) {
    const auto elements = static_cast<std::int64_t>(f.layer.size());
    const auto order = order_of(f.nodes);
    constexpr std::uint8_t quadratic_quadrilateral = 23;
    constexpr std::uint8_t quadratic_hexahedron = 25;
    std::vector<std::int64_t> connectivity;
    std::vector<std::int64_t> offsets;
    std::vector<std::int32_t> layers;
    for (std::int64_t e = 0; e < elements; ++e) {
        for (const std::int64_t node : order) {
            connectivity.push_back(e * f.nodes + node);
        }
        offsets.push_back((e + 1) * f.nodes);
        layers.push_back(f.layer[static_cast<std::size_t>(e)] + 1);
    }
    const std::vector<std::uint8_t> types(static_cast<std::size_t>(elements),
                                          f.nodes == 8 ? quadratic_quadrilateral : quadratic_hexahedron);
    Eigen::MatrixXd position = f.position;
    Eigen::MatrixXd displacement = f.displacement;
    position.row(2) *= -1.0;
    displacement.row(2) *= -1.0;

    std::string text = "<?xml version=\"1.0\"?>\n"
                       "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
                       "header_type=\"UInt64\">\n<UnstructuredGrid>\n";
    text += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", f.position.cols(), elements);
    text += "<Points>\n" + real_array("position_m", 3, position) + "</Points>\n<Cells>\n" +
            data_array("Int64", "connectivity", 1, connectivity) + data_array("Int64", "offsets", 1, offsets) +
            data_array("UInt8", "types", 1, types) + "</Cells>\n<PointData>\n" +
            real_array("displacement_m", 3, displacement) +
            real_array("deflection_mm", 1, f.displacement.row(2) / unit::mm) +
            real_array("strain_microstrain", 6, tensor(f.strain, 0.5, 1.0 / unit::microstrain)) +
            real_array("stress_kPa", 6, tensor(f.stress, 1.0, 1.0 / unit::kPa)) +
            real_array("theta_kPa", 1, f.theta / unit::kPa) + real_array("tau_kPa", 1, f.tau / unit::kPa) +
            real_array("horizontal_modulus_MPa", 1, f.horizontal_modulus / unit::MPa) +
            real_array("vertical_modulus_MPa", 1, f.vertical_modulus / unit::MPa) +
            real_array("n", 1, f.horizontal_modulus.cwiseQuotient(f.vertical_modulus)) + "</PointData>\n<CellData>\n" +
            data_array("Int32", "layer", 1, layers) + "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    return text;
}

std::vector<std::string> write_fields(const study::Study& study, const pave::pavement::ForwardModel& model,
                                      const pave::pavement::Case& at, const std::string& file) {
    std::vector<std::string> written;
    for (std::size_t l = 0; l < study.model.loads.size(); ++l) {
        const auto fields = model.fields(at, static_cast<int>(l));
        if (!fields) {
            throw std::runtime_error(fields.failure().reason);
        }
        std::filesystem::path path(file);
        if (study.model.loads.size() > 1) {
            std::string load = study.model.loads[l].name;
            std::replace(load.begin(), load.end(), '/', '_'); // a name is no folder
            path.replace_filename(path.stem().string() + "-" + load + path.extension().string());
        }
        const std::string folder = path.parent_path().string();
        run::write_file(folder.empty() ? "." : folder, path.filename().string(), vtu_text(fields.value()));
        written.push_back(path.string());
    }
    return written;
}

} // namespace explore::report
