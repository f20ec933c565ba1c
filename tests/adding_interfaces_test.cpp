// The entries of docs/adding/ that other programs and people meet: the export, the controller, the route and the texts of
// examples/adding at work.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/rehearsal/virtual_device.hpp"
#include "tumble/report/report.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/units/testing/asserts.hpp"
#include "tumble/wire/controllers.hpp"

namespace tumble {
namespace routes {
std::vector<Route> my_routes();
}  // namespace routes

namespace {

std::string text_of_file(const std::string& name) {
  std::ifstream file(TUMBLE_SOURCE_DIR "/" + name);
  EXPECT_TRUE(file) << name;
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The numbers after "<name> = [".
std::vector<double> numbers_of(const std::string& file, const std::string& name) {
  const auto begin = file.find("\n" + name + " = [");
  if (begin == std::string::npos) return {};
  std::string line = file.substr(file.find('[', begin) + 1);
  line.resize(line.find(']'));
  for (char& c : line)
    if (c == ',' || c == ';') c = ' ';
  std::istringstream words(line);
  return {std::istream_iterator<double>(words), {}};
}

/// Scale factors, misalignments and biases of the sizes that small units have.
ImuCalibration calibration() {
  ImuCalibration c;
  c.gyros.calibrated = c.accelerometers.calibrated = true;
  c.gyros.axes = c.accelerometers.axes = {true, true, true};
  c.gyros.output = Unit::parse("rad/s"), c.accelerometers.output = Unit::parse("m/s^2");
  c.gyros.response = {{1.01, 0.002, -0.003}, {-0.001, 0.98, 0.004}, {0.005, -0.002, 1.02}};
  c.accelerometers.response = {{0.99, -0.004, 0.001}, {0.002, 1.03, -0.003}, {-0.002, 0.001, 1.005}};
  c.gyros.bias = {0.01, -0.02, 0.005}, c.accelerometers.bias = {0.1, 0.05, -0.2};
  return c;
}

Vector3 corrected(const std::string& file, const std::string& name, Vector3 raw) {
  const auto m = numbers_of(file, name + ".matrix"), b = numbers_of(file, name + ".bias");
  EXPECT_EQ(m.size(), 9u) << file;
  EXPECT_EQ(b.size(), 3u) << file;
  if (m.size() != 9 || b.size() != 3) return {};
  return Matrix3{{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}} * (raw - Vector3{b[0], b[1], b[2]});
}

TEST(AddingExport, GivesTheInputsBack) {
  const ImuSample truth{.force = {1.0, -4.0, 9.5}, .rate = {0.3, -1.5, 2.0}};
  const ImuSample raw = outputs_of(calibration(), truth);
  const std::string file = export_calibration(find_export("my_export"), calibration(), {});
  // The file holds each double exactly; ten products and sums of numbers below 10, each rounded to 1e-16 of itself.
  EXPECT_LT(norm(corrected(file, "board.gyro", raw.rate) - truth.rate), 1e-13);
  EXPECT_LT(norm(corrected(file, "board.accelerometer", raw.force) - truth.force), 1e-13);
  EXPECT_EQ(file.substr(0, 2), "# ");
}

TEST(AddingExport, RefusesATermThatItCannotCarryUnlessTheUserDropsIt) {
  ImuCalibration c = calibration();
  c.gyros.by_force = {{1e-5, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "gyro_acceleration_sensitivity", .pattern = "cannot carry"},
                      [&] { export_calibration(find_export("my_export"), c, {}); }));
  const std::string file = export_calibration(find_export("my_export"), c, {.drop = {"gyro_acceleration_sensitivity"}});
  EXPECT_NE(file.find("# dropped: gyro_acceleration_sensitivity"), std::string::npos) << file;
  EXPECT_EQ(numbers_of(file, "board.gyro.bias"), (std::vector<double>{0.01, -0.02, 0.005}));
}

const ControllerRequest sweep{
    ControllerVerb::sweep,
    {{"amplitude", si(2.0, "deg")}, {"frequency", 1.0}, {"to_frequency", 20.0}, {"duration", 90.0}}};

TEST(AddingController, SweepsInBothDirections) {
  const Controller table = read_controller(text_of_file("examples/adding/my_controller.toml"), "my_controller.toml");
  ControllerHost host(table);
  ControllerDevice device(table);
  std::string bytes = host.ask(sweep);
  EXPECT_EQ(bytes, "AMPLITUDE 2.0000\n");
  std::vector<ControllerRequest> understood;
  std::vector<ControllerReply> replies;
  for (int exchange = 0; exchange < 2; ++exchange) {
    for (const auto& request : device.feed(bytes)) {
      understood.push_back(request);
      device.answer({.verb = request.verb});
    }
    for (const auto& reply : host.feed(device.output())) replies.push_back(reply);
    bytes = host.next();
  }
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_EQ(replies[0].verb, ControllerVerb::sweep);
  EXPECT_EQ(replies[0].problem, "");
  ASSERT_FALSE(understood.empty());
  EXPECT_EQ(understood.back().verb, ControllerVerb::sweep);
  // 90 s are 1.5000 min on the line: nothing is lost but the rounding of one product.
  EXPECT_NEAR(understood.back().values.at("duration"), 90.0, 1e-12);
}

TEST(AddingController, RefusesAVerbThatDoesNotExist) {
  std::string text = text_of_file("examples/adding/my_controller.toml");
  text.replace(text.find("[command.stop]"), 14, "[command.halt]");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"halt"}, .file = "my_controller.toml"},
                      [&] { read_controller(text, "my_controller.toml"); }));
}

TEST(AddingController, TheVirtualRigCarriesOutEveryVerb) {
  auto declared = controller_verbs();
  std::ranges::sort(declared);
  EXPECT_EQ(virtual_verbs(), declared);
}

TEST(AddingController, ThePageNamesEveryVerb) {
  const std::string page = text_of_file("docs/formats/controllers.md");
  const auto begin = page.find("\nVerbs: ");
  ASSERT_NE(begin, std::string::npos);
  std::string list = page.substr(begin + 8, page.find('.', begin) - begin - 8);
  std::ranges::replace(list, ',', ' ');
  std::istringstream words(list);
  std::vector<std::string> named{std::istream_iterator<std::string>(words), {}}, declared = controller_verbs();
  std::ranges::sort(named);
  std::ranges::sort(declared);
  EXPECT_EQ(named, declared);
}

/// A result with one limit that it keeps, in the folder of a workbench.
class AddingRoute : public ::testing::Test {
 protected:
  void SetUp() override {
    Estimate estimate;
    estimate.method = "my_gyro_drift";
    estimate.parameters = {{"D_F", "D_F", Unit::parse("deg/h"), si(1.8, "deg/h"), "constant drift"}};
    settle(estimate, {from_variances("output noise", {si(0.1, "deg/h") * si(0.1, "deg/h")})});
    estimate.verdicts = {{"D_F", Verdict::Outcome::pass, {.upper = bound(2.0, "deg/h")}}};
    std::ofstream(folder_.file("drift.json")) << to_json(estimate);
    std::ofstream(folder_.file("other.json")) << "{}";
    options_.folder = folder_.path;
    options_.cache = folder_.path / "cache";
    options_.clock = [] { return 0.0; };
  }

  HttpResponse get(const std::string& file) {
    routes::Context context(options_);
    HttpRequest request;
    request.query = {{"file", file}};
    return routes::my_routes().front().answer(context, request);
  }

  ScratchFolder folder_;
  WorkbenchOptions options_;
};

TEST_F(AddingRoute, AnswersWithTheVerdicts) {
  const auto answer = nlohmann::json::parse(get("drift.json").body);
  EXPECT_EQ(answer["method"], "my_gyro_drift");
  ASSERT_EQ(answer["verdicts"].size(), 1u);
  EXPECT_EQ(answer["verdicts"][0]["outcome"], "pass");
  EXPECT_EQ(answer["verdicts"][0]["limit"], "<= 2 deg/h");
}

TEST_F(AddingRoute, RefusesAFileThatIsNoResult) {
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "other.json"}, [&] { get("other.json"); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"../drift.json"}}, [&] { get("../drift.json"); }));
}

TEST_F(AddingRoute, IsDescribedAsItAnswers) {
  const auto description = nlohmann::json::parse(text_of_file("examples/adding/my_route.json"));
  const auto route = routes::my_routes().front();
  ASSERT_TRUE(description.contains(route.path));
  const auto& entry = description[route.path].at("get");
  ASSERT_EQ(route.method, "GET");
  const std::string said = entry["responses"]["200"]["description"];
  const auto answer = nlohmann::json::parse(get("drift.json").body);
  for (const auto& [name, value] : answer.items()) EXPECT_NE(said.find(name), std::string::npos) << name;
  for (const auto& [name, value] : answer["verdicts"][0].items()) EXPECT_NE(said.find(name), std::string::npos) << name;
  const auto whole = nlohmann::json::parse(text_of_file("web/openapi.json"));
  for (const auto& parameter : entry["parameters"])
    EXPECT_TRUE(whole.contains(nlohmann::json::json_pointer(parameter["$ref"].get<std::string>().substr(1))));
}

}  // namespace
}  // namespace tumble
