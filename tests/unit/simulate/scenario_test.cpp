#include "simulate/scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "core/file.h"
#include "core/toml_reader.h"
#include "support/error_of.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Every key there is, but for those that others replace.
constexpr const char* kEveryKey = R"(
seed = 7
[camera]
size = "640x480"
focal_px = 500.5
blur_px = 0.5
vignetting = 0.1
haze = 0.2
brightness = 1.1
full_well = 5000
read_noise = 3
pixel_format = "BayerGB8"
background = "wood"
fps = 50
exposure_ms = 2
distance = 1.5
rows_read_ms = 5
[camera.auto_exposure]
lag_s = 0.1
longest_ms = 10
largest_gain = 4
[swarm]
robots = 3
size = "7x6"
variant = "unconstrained"
side = 0.2
first_id = 20
margin_cells = 1
ink = "matte"
ink_spread_cells = 0.1
print = "office"
print_scale = [1.01, 1]
register = "0.1mm"
fading = 0.2
dirt = 0.03
gloss = 1.5
bend = "-2m"
bend_angle_deg = 90
speed = 0.2
acceleration = 2
gap = 0.03
height_spread = 0.1
tilt_deg = 3
arena = [1.0, 0.8]
[[phase]]
kind = "flicker"
seconds = 0.5
name = "tubes"
light = 0.9
frequency_hz = 120
depth = 0.2
[[phase]]
kind = "hands"
frames = 5
share = 0.5
occluded = [0.1, 0.2]
hand_s = 1
patches = 4
[[phase]]
kind = "shadow"
frames = 5
takes = 0.5
edge_px = 3
edge_speed_px_s = 10
[[phase]]
kind = "turn"
frames = 5
turn_deg = 180
tilt_deg = -2
over_s = 0.1
[[phase]]
kind = "traffic"
frames = 5
share = 0.25
speed = 0.7
)";

/// The message about a text with one phase or none.
std::string ErrorIn(const std::string& text) {
  return test::ErrorOf([&] { ParseScenario(text, "s.toml"); });
}

std::string ErrorInPhase(const std::string& lines) { return ErrorIn("[[phase]]\n" + lines); }

TEST(Scenario, HasDefaultsForAllButItsPhases) {
  const Scenario scenario = ParseScenario("[[phase]]\nkind = \"calm\"\nframes = 3\n", "s.toml");
  EXPECT_EQ(scenario.camera.render.camera.width, 1280);
  EXPECT_EQ(scenario.swarm.robots, 16);
  EXPECT_EQ(scenario.FrameCount(), 3);
  EXPECT_FALSE(scenario.camera.auto_exposure.has_value());
  EXPECT_EQ(scenario.phases[0].name, "calm");
  EXPECT_EQ(scenario.phases[0].speed_m_s, scenario.swarm.speed_m_s);
}

TEST(Scenario, ReadsEveryKey) {
  const Scenario scenario = ParseScenario(kEveryKey, "s.toml");
  EXPECT_EQ(scenario.seed, 7u);
  EXPECT_EQ(scenario.camera.render.camera.width, 640);
  EXPECT_EQ(scenario.camera.render.camera.fx, 500.5);
  EXPECT_EQ(scenario.camera.render.format, PixelFormat::kBayerGb8);
  EXPECT_EQ(scenario.camera.render.sensor.exposure, 1.1);
  EXPECT_EQ(scenario.camera.background.kind, BackgroundKind::kWood);
  EXPECT_EQ(scenario.camera.auto_exposure->longest_ms, 10);
  EXPECT_EQ(scenario.swarm.size, (MarkerSize{7, 6}));
  EXPECT_EQ(scenario.swarm.first_id, 20u);
  EXPECT_EQ(scenario.swarm.print.scale, Eigen::Vector2d(1.01, 1));
  EXPECT_EQ(scenario.swarm.print.register_m, 1e-4);
  EXPECT_EQ(scenario.swarm.print.fading, 0.2);
  EXPECT_EQ(scenario.swarm.print.dirt, 0.03);
  EXPECT_EQ(scenario.swarm.print.gloss, 1.5);
  EXPECT_EQ(scenario.swarm.print.bend_radius_m, -2);
  EXPECT_NEAR(scenario.swarm.print.bend_angle_rad.value(), M_PI / 2, 1e-12);
  EXPECT_EQ(scenario.swarm.arena_m->y(), 0.8);
  EXPECT_EQ(scenario.phases[0].frames, 25);
  EXPECT_EQ(scenario.phases[0].name, "tubes");
  EXPECT_EQ(scenario.phases[0].flicker_hz, 120);
  EXPECT_EQ(scenario.phases[1].occluded_most, 0.2);
  EXPECT_EQ(scenario.phases[2].shadow_width_px, 3);
  EXPECT_NEAR(scenario.phases[3].turn_rad, M_PI, 1e-12);
  EXPECT_EQ(scenario.phases[4].leave_share, 0.25);
  EXPECT_EQ(scenario.phases[4].speed_m_s, 0.7);
}

TEST(Scenario, NumbersPhasesOfOneName) {
  const Scenario scenario = ParseScenario(
      "[[phase]]\nkind = \"calm\"\nframes = 1\n[[phase]]\nkind = \"dark\"\nname = \"calm\"\nframes = 1\n"
      "[[phase]]\nkind = \"calm\"\nframes = 1\n",
      "s.toml");
  EXPECT_EQ(scenario.phases[1].name, "calm-2");
  EXPECT_EQ(scenario.phases[2].name, "calm-3");
}

TEST(Scenario, NamesFileLineKeyAndRangeOfWhatIsWrong) {
  EXPECT_THAT(ErrorInPhase("kind = \"dark\"\nframes = 2\nlight = 3\n"),
              AllOf(HasSubstr("s.toml:4"), HasSubstr("light = 3"), HasSubstr("from 0.001 to 1")));
  EXPECT_THAT(ErrorInPhase("kind = \"storm\"\nframes = 2\n"), AllOf(HasSubstr("s.toml:2"), HasSubstr("knock")));
  EXPECT_THAT(ErrorInPhase("kind = \"calm\"\n"), AllOf(HasSubstr("s.toml:1"), HasSubstr("frames")));
  EXPECT_THAT(ErrorInPhase("kind = \"calm\"\nframes = 2\nseconds = 1\n"), HasSubstr("s.toml:4: phase"));
  EXPECT_THAT(ErrorInPhase("kind = \"hands\"\nframes = 2\noccluded = [0.4, 0.2]\n"), HasSubstr("occluded"));
  EXPECT_THAT(ErrorIn("seed = 1\n"), HasSubstr("phase"));
}

TEST(Scenario, RefusesWhatBelongsToAnotherKind) {
  EXPECT_THAT(ErrorInPhase("kind = \"calm\"\nframes = 2\nlight = 0.5\n"),
              AllOf(HasSubstr("s.toml:4"), HasSubstr("light")));
  EXPECT_THAT(ErrorInPhase("kind = \"dark\"\nframes = 2\nmax_px = 5\n"), HasSubstr("max_px"));
  EXPECT_THAT(ErrorIn("[camera]\nfokal_px = 3\n[[phase]]\nkind = \"calm\"\nframes = 1\n"),
              AllOf(HasSubstr("s.toml:2"), HasSubstr("fokal_px")));
}

TEST(Scenario, RefusesWhatDoesNotGoTogether) {
  const std::string phase = "[[phase]]\nkind = \"calm\"\nframes = 1\n";
  EXPECT_THAT(ErrorIn("[camera]\nfps = 100\nexposure_ms = 11\n" + phase), HasSubstr("exposure_ms"));
  EXPECT_THAT(ErrorIn("[camera]\nsize = \"641x480\"\npixel_format = \"YUYV\"\n" + phase), HasSubstr("even width"));
  EXPECT_THAT(ErrorIn("[camera]\nsize = \"640\"\n" + phase), HasSubstr("WIDTHxHEIGHT"));
  EXPECT_THAT(ErrorIn("[swarm]\nsize = \"3x3\"\nvariant = \"golay\"\n" + phase), HasSubstr("variant"));
  EXPECT_THAT(ErrorIn("[swarm]\nrobots = 5\nfirst_id = 2045\n" + phase), HasSubstr("first_id"));
  EXPECT_THAT(ErrorIn("[swarm]\nside = 0.2\nbend = \"-10cm\"\n" + phase),
              AllOf(HasSubstr("s.toml:3"), HasSubstr("bend"), HasSubstr("at least 0.2 m")));
  EXPECT_THAT(ErrorIn("[swarm]\nbend = 2000\n" + phase), AllOf(HasSubstr("bend"), HasSubstr("1000")));
  EXPECT_THAT(ErrorIn("[swarm]\nbend_angle_deg = 10\n" + phase), AllOf(HasSubstr("bend_angle_deg"), HasSubstr("bend")));
  EXPECT_THAT(ErrorIn("[camera]\nbackground = \"lawn.png\"\n" + phase), HasSubstr("lawn.png"));
  EXPECT_THAT(ErrorInPhase("kind = \"gap\"\nframes = 3\n"), HasSubstr("must have a frame"));
  EXPECT_THAT(ErrorIn("[[phase]]\nkind = \"calm\"\nframes = 100000\n" + phase), HasSubstr("100000 frames in all"));
}

/// The keys of a table, and of the tables in it.
void AddKeys(TomlTable table, std::set<std::string>& keys) {
  for (const auto& [key, value] : table.Texts()) {
    keys.insert(key);
    if (!value.empty() && value.front() == '{') AddKeys(table.Table(key), keys);
  }
}

TEST(Scenario, TheManualKnowsEveryKey) {
  TomlFile file = TomlFile::Parse(kEveryKey, "s.toml");
  std::set<std::string> keys{"calibration", "frames", "max_px"};
  for (const char* table : {"camera", "swarm"}) AddKeys(file.root().Table(table), keys);
  for (const TomlTable& phase : file.root().Tables("phase", 100)) AddKeys(phase, keys);
  EXPECT_GT(keys.size(), 45u);
  const std::filesystem::path sources = std::filesystem::path(CHEQUER_TEST_DATA).parent_path();
  const std::string page = ReadFile(sources / "src/manual/pages/chequer-scenario.toml.5", 100'000);
  keys.erase("auto_exposure");  // a heading
  for (const std::string& key : keys) EXPECT_THAT(page, HasSubstr("\\fB" + key + "\\fR"));
  for (const auto& [kind, value] : kPhaseKinds) EXPECT_THAT(page, HasSubstr("\\fB" + std::string(kind) + "\\fR"));
}

TEST(Scenario, TheExamplesCanBeRead) {
  const std::filesystem::path sources = std::filesystem::path(CHEQUER_TEST_DATA).parent_path();
  std::set<PhaseKind> kinds;
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sources / "examples/scenarios")) {
    const Scenario scenario = LoadScenario(entry.path());
    EXPECT_GT(scenario.FrameCount(), 0) << entry.path();
    for (const Phase& phase : scenario.phases) kinds.insert(phase.kind);
    ++count;
  }
  EXPECT_EQ(count, 5);
  EXPECT_EQ(kinds.size(), kPhaseKinds.size()) << "every kind has an example";
}

}  // namespace
}  // namespace chequer
