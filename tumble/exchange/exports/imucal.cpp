#include <cmath>
#include <nlohmann/json.hpp>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::exports::imucal {
namespace {

using namespace writing;
using Json = nlohmann::ordered_json;

std::vector<std::string> carries() {
  auto names = terms_ending({"bias", "scale_factor", "misalignment"});
  names.emplace_back("gyro_acceleration_sensitivity");
  return names;
}

std::vector<Option> options() { return {}; }

Json json(Vector3 v) { return {v.x, v.y, v.z}; }
Json json(const Matrix3& m) { return {json(m.x), json(m.y), json(m.z)}; }

/// K: the lengths of the rows; R: the rows of unit length.
void add_response(const Matrix3& response, double factor, const char* k, const char* r, Json& file) {
  const Vector3 lengths{norm(response.x), norm(response.y), norm(response.z)};
  file[k] = json(factor * diagonal3(lengths));
  file[r] = json(Matrix3{response.x / lengths.x, response.y / lengths.y, response.z / lengths.z});
}

/// Raw rates in deg/s as imucal's users have them; raw counts stay counts.
std::string write(const ImuCalibration& c, const Settings&, const std::vector<std::string>& header) {
  if (!c.accelerometers.calibrated || !c.gyros.calibrated)
    throw Error(Error::Kind::bad_input,
                "imucal needs accelerometers and gyros: a result of imu_ferraris, imu_turntable "
                "or imu_multi_position with both");
  const bool rates = c.gyros.output.dimension() == Unit::parse("deg/s").dimension();
  const bool forces = c.accelerometers.output.dimension() == Unit::parse("m/s^2").dimension();
  const double output = rates ? degrees_per_radian : 1.0;  // of the file for one of SI
  std::string comment;
  for (const auto& line : header) comment += (comment.empty() ? "" : "\n") + line;
  Json file{{"acc_unit", "m/s^2"},
            {"gyr_unit", "deg/s"},
            {"from_acc_unit", forces ? "m/s^2" : c.accelerometers.output.text()},
            {"from_gyr_unit", rates ? "deg/s" : c.gyros.output.text()},
            {"comment", comment}};
  add_response(c.accelerometers.response, 1.0, "K_a", "R_a", file);
  file["b_a"] = json(c.accelerometers.bias);
  add_response(c.gyros.response, output / degrees_per_radian, "K_g", "R_g", file);
  file["K_ga"] = json(output * c.gyros.by_force);
  file["b_g"] = json(output * c.gyros.bias);
  file["cal_type"] = "Ferraris";
  file["_format_version"] = "2.0.0";
  return file.dump(4) + "\n";
}

}  // namespace

extern const Export imucal{
    .name = "imucal",
    .summary = "imucal: JSON of a Ferraris calibration",
    .formula =
        "acc = inv(R_a) inv(K_a) (raw - b_a), gyr = inv(R_g) inv(K_g) (raw - K_ga acc - b_g); K diagonal, rows of "
        "R of unit length",
    .units = "m/s^2 and deg/s, from m/s^2 and deg/s or from raw counts",
    .frame = "axes of the calibration",
    .source = "github.com/mad-lab-fau/imucal: imucal/ferraris_calibration_info.py",
    .comment = "",
    .extension = ".json",
    .carries = carries,
    .estimates = no_terms,
    .takes_counts = true,
    .options = options,
    .write = write};

}  // namespace tumble::exports::imucal
