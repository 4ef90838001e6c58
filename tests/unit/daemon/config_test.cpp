#include "daemon/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <sstream>

#include "chequer/camera_file.h"
#include "daemon/service.h"
#include "publish/channels.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

/// The least that is a configuration.
const std::string kMinimal = R"([capture]
path = "swarm"
[[marker]]
size = "6x6"
variant = "secded"
)";

DaemonConfig Parse(const std::string& text) { return ParseDaemonConfig(text, "a.toml", "/base"); }

std::string Refusal(const std::string& text) {
  return test::ErrorOf([&] { Parse(text); });
}

std::filesystem::path Shipped() {
  return std::filesystem::path(CHEQUER_TEST_DATA).parent_path() / "config/chequerd.toml";
}

std::string ShippedText() {
  std::ifstream file(Shipped());
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

void ExpectSameOptions(const DaemonConfig& config, const DaemonConfig& defaults) {
  EXPECT_EQ(config.camera_name, defaults.camera_name);
  EXPECT_EQ(config.detector.camera.has_value(), defaults.detector.camera.has_value());
  EXPECT_EQ(config.detector.color_space, defaults.detector.color_space);
  EXPECT_EQ(config.detector.max_luminance_overlap, defaults.detector.max_luminance_overlap);
  EXPECT_EQ(config.detector.max_saturation_overlap, defaults.detector.max_saturation_overlap);
  EXPECT_EQ(config.detector.threads, defaults.detector.threads);
  EXPECT_EQ(config.threads, defaults.threads);
  EXPECT_EQ(config.detector.print_tolerance, defaults.detector.print_tolerance);
  EXPECT_EQ(config.memory, defaults.memory);
  EXPECT_EQ(config.detector.search_every, defaults.detector.search_every);
  EXPECT_EQ(config.detector.carry_s, defaults.detector.carry_s);
  EXPECT_EQ(config.detector.learn_levels, defaults.detector.learn_levels);
  EXPECT_EQ(config.budget.choice, defaults.budget.choice);
  EXPECT_EQ(config.workers, defaults.workers);
  EXPECT_EQ(config.when_busy, defaults.when_busy);
  EXPECT_EQ(config.scheduling.cpus, defaults.scheduling.cpus);
  EXPECT_EQ(config.scheduling.realtime_priority, defaults.scheduling.realtime_priority);
  EXPECT_EQ(config.metrics.port, defaults.metrics.port);
  EXPECT_EQ(config.metrics.file, defaults.metrics.file);
  EXPECT_EQ(config.publish.url, defaults.publish.url);
  EXPECT_EQ(config.publish.prefix, DefaultPrefix(defaults.camera_name));
  EXPECT_EQ(config.allow_view, defaults.allow_view);
  EXPECT_EQ(config.log.level, defaults.log.level);
  EXPECT_EQ(config.log.target, defaults.log.target);
  EXPECT_EQ(config.capture.source, defaults.capture.source);
  EXPECT_EQ(config.capture.faults, defaults.capture.faults);
  EXPECT_EQ(config.capture.replay.images, defaults.capture.replay.images);
  EXPECT_EQ(config.capture.replay.plain.fps, defaults.capture.replay.plain.fps);
  EXPECT_EQ(config.capture.replay.plain.one_channel, defaults.capture.replay.plain.one_channel);
  EXPECT_EQ(config.capture.replay.plain.tone_curve, defaults.capture.replay.plain.tone_curve);
  EXPECT_EQ(config.capture.replay.pace, defaults.capture.replay.pace);
  EXPECT_EQ(config.capture.replay.fps, defaults.capture.replay.fps);
  EXPECT_EQ(config.capture.replay.loop, defaults.capture.replay.loop);
  EXPECT_EQ(config.capture.replay.preload, defaults.capture.replay.preload);
  EXPECT_EQ(config.capture.replay.preload_limit_bytes, defaults.capture.replay.preload_limit_bytes);
  EXPECT_EQ(config.capture.replay.times, defaults.capture.replay.times);
}

TEST(Config, ShippedFileHoldsTheDefaults) {
  ExpectSameOptions(ParseDaemonConfig(ShippedText(), "shipped.toml", Shipped().parent_path()), {});
}

TEST(Config, RemarksOnMessagesThatLeaveTheHost) {
  EXPECT_THAT(Parse(kMinimal).remarks, IsEmpty());
  EXPECT_THAT(Parse(kMinimal + "[publish]\nurl = \"udpm://239.255.76.67:7667?ttl=1\"\n").remarks,
              ElementsAre(AllOf(StartsWith("a.toml:7: publish.url = "), HasSubstr("forge"))));
}

TEST(Config, ACameraWithoutANameHasTheOneOfItsFile) {
  const test::TemporaryDirectory folder;
  const auto name_of = [&](const std::string& file, const std::string& text) {
    std::ofstream(folder / file) << text;
    const DaemonConfig config = LoadDaemonConfig(folder / file);
    EXPECT_EQ(config.publish.prefix, "CHEQUER_" + config.camera_name);
    return config.camera_name;
  };
  EXPECT_EQ(name_of("north.toml", ShippedText()), "north") << "the example, copied for an instance of the service";
  EXPECT_EQ(name_of("south-2.toml", kMinimal), "south-2");
  EXPECT_EQ(name_of("north.toml", "[camera]\nname = \"ceiling\"\n" + kMinimal), "ceiling");
  EXPECT_EQ(name_of("two words.toml", kMinimal), "camera");
  EXPECT_EQ(name_of(std::string(49, 'x') + ".toml", kMinimal), "camera") << "too long for a channel";
}

TEST(Config, LeavingEverythingOutGivesTheDefaults) { ExpectSameOptions(Parse(kMinimal), {}); }

// The message on an unknown key lists all keys that are known in its table.
TEST(Config, ShippedFileNamesEveryKey) {
  const std::string text = ShippedText();
  int keys = 0;
  for (const std::string table : {"camera", "capture", "marker", "print", "detect", "world", "robots", "tracks",
                                  "pipeline", "publish", "metrics", "log"}) {
    const std::string header = table == "marker" ? "[[marker]]" : "[" + table + "]";
    std::string with_unknown = text;
    const std::size_t place = with_unknown.find(header + "\n");
    ASSERT_NE(place, std::string::npos) << header;
    with_unknown.insert(place + header.size() + 1, "no_such_key = 1\n");
    const std::string message = Refusal(with_unknown);
    const std::string known = "known here: ";
    ASSERT_THAT(message, AllOf(HasSubstr(table), HasSubstr("no_such_key"), HasSubstr(known)));
    const std::string section = text.substr(place, text.find("\n[", place) - place);
    std::istringstream names(message.substr(message.find(known) + known.size()));
    for (std::string name; std::getline(names >> std::ws, name, ','); ++keys)
      EXPECT_TRUE(std::regex_search(section, std::regex("\n#?" + name + " = "))) << table << "." << name;
  }
  EXPECT_GE(keys, 30);
}

/// The shipped text with another source, and without the keys of replaying, which the file holds as they are.
std::string WithSource(const std::string& text, const std::string& source) {
  const std::regex of_replay("\n(path|one_channel|pace|replay_fps|loop|preload|preload_limit_mb|times) = [^\n]*");
  const std::regex source_line("\nsource = [^\n]*");
  return std::regex_replace(std::regex_replace(text, of_replay, ""), source_line, "\nsource = \"" + source + "\"");
}

TEST(Config, ShippedFileNamesEveryKeyOfCameras) {
  const std::string text = ShippedText();
  for (const std::string source : {"v4l2", "aravis"}) {
    EXPECT_THAT(Refusal(WithSource(text, source)), "no error");
    const std::string message = Refusal(WithSource(
        std::regex_replace(text, std::regex("\nsource = [^\n]*"), "\nsource = \"\"\nno_such_key = 1"), source));
    const std::string known = "known here: ";
    ASSERT_THAT(message, AllOf(HasSubstr("capture.no_such_key"), HasSubstr(known)));
    int keys = 0;
    std::istringstream names(message.substr(message.find(known) + known.size()));
    for (std::string name; std::getline(names >> std::ws, name, ','); ++keys)
      EXPECT_TRUE(std::regex_search(text, std::regex("\n#?" + name + " = "))) << source << "." << name;
    EXPECT_GE(keys, 10);
  }
}

// Under the heading of another kind of source, each key is refused as that kind's.
TEST(Config, NamesTheSourceThatAKeyIsFor) {
  std::istringstream lines(ShippedText());
  std::string heading;
  int keys = 0;
  for (std::string line; std::getline(lines, line) && line != "[world]";) {
    if (line.starts_with("# With ")) heading = line;
    std::smatch key;
    if (heading.find("source = ") == std::string::npos || !std::regex_match(line, key, std::regex("#?(\\w+) = (.*)")))
      continue;
    if (line.starts_with("[[marker]]")) break;
    ++keys;
    for (const std::string source : {"replay", "v4l2", "aravis"}) {
      const bool its_own = heading.find("\"" + source + "\"") != std::string::npos;
      const std::string path = source == "replay" && key[1] != "path" && key[1] != "images" ? "path = \"swarm\"\n" : "";
      const std::string refusal = Refusal("[capture]\nsource = \"" + source + "\"\n" + path + key.str(1) + " = " +
                                          key.str(2) + "\n[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\n");
      if (its_own)
        EXPECT_THAT(refusal, ::testing::Not(HasSubstr("is for source"))) << source << ": " << line;
      else
        EXPECT_THAT(refusal, HasSubstr("it is for source = ")) << source << ": " << line;
    }
  }
  EXPECT_GE(keys, 25);
}

TEST(Config, TellsASideThatLooksLikeMillimetres) {
  const DaemonConfig config =
      Parse("[capture]\npath = \"swarm\"\n[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\nside = 60\n");
  ASSERT_EQ(config.remarks.size(), 1u);
  EXPECT_THAT(config.remarks[0], HasSubstr("did you mean \"60mm\"?"));
  EXPECT_TRUE(Parse(kMinimal).remarks.empty());
}

TEST(Config, ShippedFileNamesNoOtherKey) {
  // With every left-out line put in, only those may be refused that exclude each other, each for that reason.
  const std::string text = ShippedText();
  const std::regex left_out("\n#(\\w+) = [^\n]*");
  const std::map<std::string, std::string> conditions = {{"images", "beside path"},
                                                         {"table", "only for variant"},
                                                         {"calibration", "camera.toml"},
                                                         {"file = \"world.toml\"", "needs camera.calibration"},
                                                         {"file = \"robots.toml\"", "needs camera.calibration"},
                                                         {"frames", "needs world.file"},
                                                         {"width", "both sides"},
                                                         {"height", "both sides"}};
  int lines = 0;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), left_out); it != std::sregex_iterator();
       ++it, ++lines) {
    std::string put_in = text;
    put_in.erase(static_cast<std::size_t>(it->position()) + 1, 1);
    std::string refusal = Refusal(put_in);
    for (const char* source : {"v4l2", "aravis"})
      if (refusal.find("unknown key") != std::string::npos) refusal = Refusal(WithSource(put_in, source));
    const auto condition = std::find_if(conditions.begin(), conditions.end(),
                                        [&](const auto& entry) { return it->str().starts_with("\n#" + entry.first); });
    if (condition == conditions.end())
      EXPECT_THAT(refusal, "no error") << (*it)[1];
    else
      EXPECT_THAT(refusal, HasSubstr(condition->second)) << (*it)[1];
  }
  EXPECT_GE(lines, 5);
}

TEST(Config, RefusesWithFileLineKeyAndRange) {
  EXPECT_THAT(Refusal(kMinimal + "[detect]\nthreads = 65\n"),
              AllOf(StartsWith("a.toml:7: detect.threads = 65"), HasSubstr("1 to 64")));
  EXPECT_THAT(Refusal(kMinimal + "[detect]\nmax_luminance_overlap = 0.6\n"), HasSubstr("0 to 0.5"));
  EXPECT_THAT(Refusal(kMinimal + "[detect]\nmax_saturation_overlap = -0.1\n"), HasSubstr("0 to 0.5"));
  EXPECT_THAT(Refusal(kMinimal + "[detect]\ncolor_space = \"rgb\"\n"), AllOf(HasSubstr("lab"), HasSubstr("hsv")));
  EXPECT_THAT(Refusal(kMinimal + "[detect]\nbudget = \"some\"\n"),
              AllOf(HasSubstr("\"auto\""), HasSubstr("\"unlimited\""), HasSubstr("1000 to 1000000000")));
  EXPECT_THAT(Refusal(kMinimal + "[detect]\nbudget = 999\n"),
              AllOf(StartsWith("a.toml:7: detect.budget = 999"), HasSubstr("1000 to 1000000000")));
  EXPECT_THAT(Refusal(kMinimal + "[detect]\nbudget = 1e6\n"), HasSubstr("whole number"));
  EXPECT_THAT(Refusal(kMinimal + "[pipeline]\nworkers = -1\n"), HasSubstr("0 to 64"));
  EXPECT_THAT(Refusal(kMinimal + "[pipeline]\nwhen_busy = \"drop\"\n"), HasSubstr("newest"));
  EXPECT_THAT(Refusal(kMinimal + "[pipeline]\ncpus = [0, 1024]\n"), HasSubstr("0 to 1023"));
  EXPECT_THAT(Refusal(kMinimal + "[pipeline]\nrealtime_priority = 99\n"), HasSubstr("0 to 98"));
  EXPECT_THAT(Refusal(kMinimal + "[metrics]\nport = 70000\n"), HasSubstr("0 to 65535"));
  EXPECT_THAT(Refusal(kMinimal + "[metrics]\nfile = \"metrics.txt\"\n"), HasSubstr(".prom"));
  EXPECT_THAT(Refusal(kMinimal + "[log]\nlevel = \"loud\"\n"), HasSubstr("warning"));
  EXPECT_THAT(Refusal(kMinimal + "[log]\ntarget = \"file\"\n"), HasSubstr("journal"));
  EXPECT_THAT(Refusal(kMinimal + "[camera]\nname = \"two words\"\n"), HasSubstr("A-Z a-z 0-9"));
  EXPECT_THAT(Refusal(kMinimal + "[camera]\nname = \"" + std::string(49, 'x') + "\"\n"), HasSubstr("48"));
  EXPECT_THAT(Refusal(kMinimal + "[publish]\nurl = \"udp://x\"\n"),
              AllOf(StartsWith("a.toml:7: publish.url"), HasSubstr("udpm://")));
  EXPECT_THAT(Refusal(kMinimal + "[publish]\nprefix = \"a b\"\n"), StartsWith("a.toml:7: publish.prefix"));
  EXPECT_THAT(Refusal(kMinimal + "[camera]\ncalibration = \"none.toml\"\n"),
              AllOf(StartsWith("a.toml:7: camera.calibration"), HasSubstr("/base/none.toml")));
  EXPECT_THAT(Refusal(kMinimal + "[surprise]\nx = 1\n"), HasSubstr("surprise"));
  EXPECT_THAT(Refusal("[capture]\npath = \"swarm\"\n"), HasSubstr("[[marker]]"));
  EXPECT_THAT(Refusal(kMinimal.substr(kMinimal.find("[[marker]]"))), HasSubstr("capture.path"));
}

/// kMinimal's marker with other lines.
std::string WithMarker(const std::string& lines) { return "[capture]\npath = \"swarm\"\n[[marker]]\n" + lines; }

TEST(Config, ReadsABudgetAsAWordOrANumber) {
  EXPECT_EQ(Parse(kMinimal).budget.choice, BudgetChoice::kAuto);
  EXPECT_EQ(Parse(kMinimal + "[detect]\nbudget = \"unlimited\"\n").budget.choice, BudgetChoice::kUnlimited);
  const BudgetOptions budget = Parse(kMinimal + "[detect]\nbudget = 50000\n").budget;
  EXPECT_EQ(budget.choice, BudgetChoice::kUnits);
  EXPECT_EQ(budget.units, 50'000u);
}

TEST(Config, ReadsWhetherFramesHaveAMemory) {
  EXPECT_TRUE(Parse(kMinimal).memory);
  EXPECT_FALSE(Parse(kMinimal + "[detect]\nmemory = false\n").memory);
  EXPECT_THAT(Refusal(kMinimal + "[detect]\nmemory = 1\n"), StartsWith("a.toml:7: detect.memory = 1"));
}

TEST(Config, ReadsSeveralKindsOfMarkers) {
  const DaemonConfig config =
      Parse(WithMarker("size = \"6x6\"\nvariant = \"secded\"\nside = 0.12\nroster = [\"0-3\", \"7\"]\n"
                       "[[marker]]\nsize = \"8x8\"\nvariant = \"golay\"\nside = 0.2\n"));
  ASSERT_EQ(config.detector.families.size(), 2u);
  EXPECT_EQ(config.detector.families[0].side_m, 0.12);
  EXPECT_THAT(config.detector.families[0].roster, ElementsAre(0, 1, 2, 3, 7));
  EXPECT_EQ(config.detector.families[1].code.variant(), Variant::kGolay);
  EXPECT_EQ(config.detector.families[1].code.size(), (MarkerSize{8, 8}));
  EXPECT_THAT(config.detector.families[1].roster, IsEmpty());
}

TEST(Config, ReadsIdsOf64Bits) {
  const DaemonConfig config = Parse(WithMarker(
      "size = \"10x10\"\nvariant = \"unconstrained\"\nroster = [\"18446744073709551614-18446744073709551615\"]\n"));
  EXPECT_THAT(config.detector.families[0].roster, ElementsAre(~0ull - 1, ~0ull));
}

TEST(Config, RefusesMarkersThatCannotBe) {
  const std::string good = "size = \"6x6\"\nvariant = \"secded\"\n";
  EXPECT_THAT(Refusal(WithMarker("variant = \"secded\"\n")), HasSubstr("size"));
  EXPECT_THAT(Refusal(WithMarker("size = \"6x6\"\n")), HasSubstr("variant"));
  EXPECT_THAT(Refusal(WithMarker("size = \"2x6\"\nvariant = \"secded\"\n")), HasSubstr("at least 3x3"));
  EXPECT_THAT(Refusal(WithMarker("size = \"6x6\"\nvariant = \"hamming\"\n")), HasSubstr("must be one of"));
  EXPECT_THAT(Refusal(WithMarker("size = \"6x6\"\nvariant = \"golay\"\n")), StartsWith("a.toml:5: marker"));
  EXPECT_THAT(Refusal(WithMarker(good + "side = -0.1\n")), AllOf(StartsWith("a.toml:6: "), HasSubstr("0.001 to 99")));
  EXPECT_THAT(Refusal(WithMarker(good + "table = \"t\"\n")), HasSubstr("only for variant"));
  EXPECT_THAT(Refusal(WithMarker("size = \"6x6\"\nvariant = \"table\"\n")), HasSubstr("needs a file"));
  EXPECT_THAT(Refusal(WithMarker("size = \"6x6\"\nvariant = \"table\"\ntable = \"none\"\n")), HasSubstr("/base/none"));
  EXPECT_THAT(Refusal(WithMarker(good + "roster = [\"5-1\"]\n")), HasSubstr("neither an id nor a range"));
  EXPECT_THAT(Refusal(WithMarker(good + "roster = [\"x\"]\n")), HasSubstr("neither an id nor a range"));
  EXPECT_THAT(Refusal(WithMarker(good + "roster = [\"2048\"]\n")), HasSubstr("beyond 2047"));
  EXPECT_THAT(Refusal(WithMarker("size = \"10x10\"\nvariant = \"unconstrained\"\nroster = [\"0-1000000\"]\n")),
              HasSubstr("at most 1000000"));
}

TEST(Config, NeedsASideWhereThereIsACalibration) {
  const test::TemporaryDirectory folder;
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  WriteCamera(folder / "camera.toml", camera);
  const auto parse = [&](const std::string& text) { return ParseDaemonConfig(text, "a.toml", folder.path()); };
  const std::string calibrated = "[camera]\ncalibration = \"camera.toml\"\n" + kMinimal;
  EXPECT_THROW(parse(calibrated), std::runtime_error);
  const DaemonConfig config = parse(calibrated + "side = 0.1\n");
  ASSERT_TRUE(config.detector.camera.has_value());
  EXPECT_EQ(config.detector.camera->width, 640);
  const PipelineOptions options = MakePipelineOptions(config, "1", 2);
  EXPECT_EQ(options.capture.size, (FrameSize{640, 480}));
}

TEST(Config, WarnsOfAGammaThatIsNotTheCameras) {
  const test::TemporaryDirectory folder;
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.tone_curve = ToneCurve::Gamma(1.4);
  WriteCamera(folder / "camera.toml", camera);
  const std::string rest = "[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\nside = 0.1\n";
  const auto remarks = [&](const std::string& gamma) {
    const std::string text = "[camera]\ncalibration = \"camera.toml\"\n[capture]\npath = \"swarm\"\n" + gamma + rest;
    return ParseDaemonConfig(text, "a.toml", folder.path()).remarks;
  };
  EXPECT_THAT(remarks("gamma = 2.2\n"),
              ElementsAre(AllOf(StartsWith("a.toml:5: capture.gamma"), HasSubstr("gamma 1.4"))));
  EXPECT_THAT(remarks("gamma = 1.41\n"), IsEmpty());
  EXPECT_THAT(remarks(""), IsEmpty());
}

TEST(Config, TellsWhereAndHowUrgentlyThreadsRun) {
  const DaemonConfig config = Parse(kMinimal + "[pipeline]\ncpus = [3, 1]\nrealtime_priority = 50\n");
  const PipelineOptions options = MakePipelineOptions(config, "1", 2);
  EXPECT_THAT(options.scheduling.cpus, ElementsAre(3, 1));
  EXPECT_EQ(options.scheduling.realtime_priority, 50);
}

TEST(Config, OffersMetricsWhereAskedTo) {
  const DaemonConfig config = Parse(kMinimal + "[metrics]\nport = 9464\nfile = \"a.prom\"\n");
  EXPECT_EQ(config.metrics.port, 9464);
  EXPECT_EQ(config.metrics.file, "/base/a.prom");
}

TEST(Config, LetsOthersLookWhereMessagesStayOnThisHost) {
  const auto with = [](const std::string& publish, const std::string& view) {
    return Parse(kMinimal + "[publish]\n" + publish + "\n[view]\n" + view + "\n");
  };
  const std::string leaves = "url = \"udpm://239.255.76.67:7667?ttl=1\"";
  EXPECT_TRUE(with("", "").allow_view);
  EXPECT_FALSE(with("", "allow = false").allow_view);
  EXPECT_FALSE(with(leaves, "").allow_view);
  EXPECT_TRUE(with(leaves, "allow = true").allow_view);
  EXPECT_THAT(with(leaves, "allow = true").remarks, Contains(HasSubstr("pictures, which then leave this host")));
  EXPECT_FALSE(with("url = \"memq://\"", "allow = true").allow_view) << "there is nobody who could ask";
  const std::string longest = "prefix = \"" + std::string(56, 'x') + "\"";
  EXPECT_FALSE(with(longest, "").allow_view);
  EXPECT_THAT(Refusal(kMinimal + "[publish]\n" + longest + "\n[view]\nallow = true\n"), HasSubstr("view.allow"));
}

TEST(Config, NamesTheChannelsAfterTheCamera) {
  EXPECT_EQ(Parse(kMinimal + "[camera]\nname = \"north-2\"\n").publish.prefix, "CHEQUER_north-2");
  EXPECT_EQ(Parse(kMinimal + "[publish]\nprefix = \"ARENA\"\n").publish.prefix, "ARENA");
}

TEST(Config, TakesPathsRelativeToItsFolder) {
  const test::TemporaryDirectory folder;
  std::ofstream(folder / "a.toml") << kMinimal;
  EXPECT_EQ(LoadDaemonConfig(folder / "a.toml").capture.replay.path, folder / "swarm");
  EXPECT_THROW(LoadDaemonConfig(folder / "missing.toml"), std::runtime_error);
}

TEST(Config, WaitsForRecordingsThatPlayAsFastAsTheyGo) {
  DaemonConfig config;
  const auto when_busy = [&] { return MakePipelineOptions(config, "1", 2).when_busy; };
  EXPECT_EQ(when_busy(), WhenBusy::kNewest);
  config.capture.replay.pace = ReplayPace::kUnlimited;
  EXPECT_EQ(when_busy(), WhenBusy::kWait);
  config.when_busy = WhenBusyChoice::kNewest;
  EXPECT_EQ(when_busy(), WhenBusy::kNewest);
  config.capture.replay.pace = ReplayPace::kRecorded;
  config.when_busy = WhenBusyChoice::kWait;
  EXPECT_EQ(when_busy(), WhenBusy::kWait);
}

TEST(Config, HasOneWorkerACoreUnlessToldOtherwise) {
  DaemonConfig config;
  EXPECT_EQ(MakePipelineOptions(config, "1", 6).workers, 6);
  EXPECT_EQ(MakePipelineOptions(config, "1", 0).workers, 1);  // the system does not say
  config.workers = 3;
  EXPECT_EQ(MakePipelineOptions(config, "1", 6).workers, 3);
}

}  // namespace
}  // namespace chequer
