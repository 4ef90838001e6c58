#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/file.h"
#include "core/suggestion.h"
#include "publish/channels.h"
#include "tools/commands.h"
#include "tools/length_option.h"
#include "tools/run_self.h"
#include "tools/setup_option.h"
#include "tools/start_setup.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;

struct StartRequest {
  StartAnswers answers;
  std::vector<std::string> steps;
  bool yes = false;  ///< ask nothing
  bool service = false;
  std::string references;
  std::vector<std::string> lens_frames, world_frames, robots_frames;
};

/// Asks, and takes what is typed; the default where nothing is, or where nothing may be asked.
class Asker {
 public:
  explicit Asker(bool may_ask) : may_ask_(may_ask) {}

  std::string Ask(const std::string& question, const std::string& usual) const {
    if (!may_ask_) return usual;
    fmt::print("{} [{}] ", question, usual);
    std::fflush(stdout);
    std::string typed;
    if (!std::getline(std::cin, typed)) throw std::runtime_error("the answers ended before the questions");
    return typed.empty() ? usual : typed;
  }
  bool MayAsk() const { return may_ask_; }

 private:
  bool may_ask_;
};

/// One camera's way from the box to poses, step by step.
class Start {
 public:
  explicit Start(StartRequest& request) : request_(request), answers_(request.answers), asker_(!request.yes) {}

  void Run() {
    for (const Step& step : kSteps)
      if (request_.steps.empty() || std::count(request_.steps.begin(), request_.steps.end(), step.name) > 0) Take(step);
    fmt::print(
        "\nDone. `chequerd --config {0}` runs it, `chequer listen` shows what it sees, `chequer status {1}` how "
        "it fares.\n",
        answers_.Config().string(), answers_.name);
  }

  struct Step {
    std::string_view name;
    std::string_view what;
    void (Start::*work)();
  };
  static const std::array<Step, 6> kSteps;

 private:
  void Take(const Step& step) {
    fmt::print("\n== {}: {}\n", step.name, step.what);
    if (step.name != "camera" && !fs::exists(answers_.Config()))
      throw std::runtime_error(answers_.Config().string() +
                               " is not there: the step camera makes it (chequer start camera)");
    if (asker_.MayAsk()) {
      const std::string answer = asker_.Ask("Enter: do it; s: skip it; q: end", "do it");
      if (answer == "q") throw CLI::RuntimeError(kExitOk);
      if (answer == "s") return;
    }
    doing_ = step.name;
    (this->*step.work)();
  }

  void Camera() {
    if (fs::exists(answers_.Config())) {
      fmt::print("{} is there, and kept as it is.\n", answers_.Config().string());
      return;
    }
    if (answers_.recording.empty() && answers_.device.empty()) {
      Self({"cameras"});
      answers_.device = asker_.Ask("Which camera (node, name or serial number)?", "the only one");
      if (answers_.device == "the only one") answers_.device.clear();
    }
    if (asker_.MayAsk()) {
      answers_.side = asker_.Ask("How long is a side of the robots' markers?", answers_.side);
      answers_.robots = ParseRobots(asker_.Ask("How many robots?", std::to_string(answers_.robots)));
    }
    ParseLengthOption("--side", answers_.side);
    WriteFileAtomically(answers_.Config(), StartConfiguration(answers_));
    fmt::print("Written: {}. Edit it as you like; chequerd.toml(5) has every key.\n", answers_.Config().string());
  }

  void Print() {
    Self({"print", "--config", answers_.Config(), "--out", answers_.File("markers.pdf")});
    Self({"print", "--config", answers_.Config(), "--marker", "6x6", "--side", kLensSheetSide, "--ids", kLensSheetIds,
          "--out", answers_.File("lens.pdf")});
    fmt::print(
        "Print both without \"fit to page\" and hold a ruler to the bars. Glue {0} to something flat. Cut out {1}:\n"
        "the robots' arrows point forward; the last three markers lie on the floor.\n",
        answers_.File("lens.pdf").string(), answers_.File("markers.pdf").string());
  }

  void Lens() {
    std::vector<std::string> words{"calibrate", "lens",   "--config",     answers_.Config(), "--marker",
                                   "6x6",       "--side", kLensSheetSide, "--ids",           kLensSheetIds};
    fmt::print("Hold {} into all parts of the image, tilted to all sides. It says when it is enough.\n",
               answers_.File("lens.pdf").string());
    Calibrate(words, request_.lens_frames, "camera.toml", CalibrationLine(answers_));
  }

  void World() {
    std::vector<std::string> words{"calibrate", "world", "--config", answers_.Config()};
    if (request_.references.empty()) {
      const std::string corner = LOfThree();
      words.insert(words.end(), {"--l", corner});
      fmt::print("Lay the markers {} on the floor: the corner of the room's frame, one along x, one along y.\n",
                 corner);
    } else {
      words.push_back(request_.references);
    }
    Calibrate(words, request_.world_frames, "world.toml", WorldLine(answers_));
  }

  void Robots() {
    fmt::print("Let the robots stand or drive on the floor.\n");
    Calibrate({"calibrate", "robots", "--config", answers_.Config()}, request_.robots_frames, "robots.toml",
              RobotsLine(answers_));
    fmt::print("Put the robots' names into {}, and where the markers sit on them (chequer-robots.toml(5)).\n",
               answers_.File("robots.toml").string());
  }

  void Service() {
    const std::string unit = "chequerd@" + answers_.name;
    const std::vector<std::string> words{"enable", "--now", unit};
    if (fs::weakly_canonical(answers_.folder) != kServiceFolder) {
      const std::string why = fmt::format("the service reads {}: copy {} and the files it names there, then\n  {}",
                                          kServiceFolder, answers_.Config().string(), ShellText("systemctl", words));
      if (request_.service) throw std::runtime_error(why);
      fmt::print("Not done: {}\n", why);
      return;
    }
    if (!request_.service && !asker_.MayAsk()) {
      fmt::print("By hand:\n  {}\n", ShellText("systemctl", words));
      return;
    }
    fmt::print("  {}\n", ShellText("systemctl", words));
    Check(RunProgram("systemctl", words));
  }

  /// A calibration by its plain command; then the configuration takes what it wrote.
  void Calibrate(std::vector<std::string> words, const std::vector<std::string>& frames, const std::string& file,
                 const std::string& line) {
    words.insert(words.end(), frames.begin(), frames.end());
    words.insert(words.end(), {"--out", answers_.File(file)});
    Self(words);
    if (SwitchOn(answers_.Config(), line))
      fmt::print("{} names it now.\n", answers_.Config().string());
    else
      fmt::print("{} must name it: {}", answers_.Config().string(), line);
  }

  /// The three last ids of the configuration.
  std::string LOfThree() const {
    const CameraSetup setup = LoadCameraSetup(answers_.Config());
    if (setup.families.empty() || setup.families.front().roster.size() < kFloorMarkers)
      throw std::runtime_error(answers_.Config().string() +
                               ": has no roster of three ids and more; name the floor's markers by --references");
    const std::vector<std::uint64_t>& ids = setup.families.front().roster;
    return fmt::format("{},{},{}", ids[ids.size() - 3], ids[ids.size() - 2], ids[ids.size() - 1]);
  }

  /// Runs a command of this program and shows it; the user can do the same.
  void Self(const std::vector<std::string>& words) {
    fmt::print("  {}\n", ShellText("chequer", words));
    Check(RunSelf(words));
  }

  void Check(int status) const {
    if (status == 0) return;
    throw std::runtime_error(
        fmt::format("the step {0} ended with status {1}; once that is mended, `chequer start {0} "
                    "--name {2} --folder {3}` does it again, and what follows it likewise",
                    doing_, status, answers_.name, answers_.folder.string()));
  }

  static std::uint64_t ParseRobots(const std::string& typed) {
    std::size_t used = 0;
    unsigned long robots = 0;
    try {
      robots = std::stoul(typed, &used);
    } catch (const std::logic_error&) {
      used = 0;
    }
    // The ids behind them are the floor's and the lens sheet's.
    if (used == 0 || used != typed.size() || robots < 1 || robots > 2000)
      throw CLI::ValidationError("--robots", "'" + typed + "' must be a number from 1 to 2000");
    return robots;
  }

  StartRequest& request_;
  StartAnswers& answers_;
  Asker asker_;
  std::string_view doing_;
};

const std::array<Start::Step, 6> Start::kSteps{
    {{"camera", "finds the camera and begins its configuration", &Start::Camera},
     {"print", "draws the markers, and a sheet for the lens", &Start::Print},
     {"lens", "calibrates the lens", &Start::Lens},
     {"world", "finds where the camera stands in the room", &Start::World},
     {"robots", "measures the robots' markers", &Start::Robots},
     {"service", "lets systemd run chequerd", &Start::Service}}};

void RunStart(StartRequest& request) {
  std::vector<std::string> known;
  for (const Start::Step& step : Start::kSteps) known.emplace_back(step.name);
  for (const std::string& step : request.steps)
    if (std::find(known.begin(), known.end(), step) == known.end())
      throw CLI::ValidationError("STEP", UnknownWord("a step", step, known));
  if (!IsValidPrefix(request.answers.name) || request.answers.name.size() > kMaxCameraName)
    throw CLI::ValidationError("--name", "'" + request.answers.name + "' must be of the characters A-Z a-z 0-9 _ -");
  if (request.answers.robots < 1 || request.answers.robots > 2000)
    throw CLI::ValidationError("--robots", "must be from 1 to 2000");
  if (!fs::is_directory(request.answers.folder))
    throw CLI::ValidationError("--folder", "'" + request.answers.folder.string() + "' is no folder");
  Start(request).Run();
}

}  // namespace

void AddStartCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("start", "Leads from a new camera to poses in the room, step by step");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<StartRequest>();
  StartAnswers& answers = request->answers;
  command->add_option("STEP", request->steps, "Only these: camera, print, lens, world, robots, service");
  command->add_option("--name", answers.name, "Of the camera, and of all files")->capture_default_str();
  command
      ->add_option_function<std::string>(
          "--folder", [&answers](const std::string& folder) { answers.folder = folder; },
          "Where the files are; the service reads /etc/chequer")
      ->default_str(".")
      ->type_name("DIR");
  command->add_option("--device", answers.device, "The camera, as `chequer cameras` lists it [asked for]")
      ->type_name("CAMERA");
  command->add_option("--recording", answers.recording, "Frames to play instead of a camera")->type_name("DIR");
  command->add_option("--side", answers.side, "Of the robots' markers")->type_name("LENGTH")->capture_default_str();
  command->add_option("--robots", answers.robots, "How many")->type_name("N")->capture_default_str();
  command->add_option("--references", request->references, "Markers at known places [three that lie as an L]")
      ->type_name("FILE");
  command->add_flag("--yes", request->yes, "Ask nothing");
  command->add_flag("--service", request->service, "Also enable and start the service");
  const char* group = "Frames that were recorded before, instead of the camera's";
  command->add_option("--lens-frames", request->lens_frames, "Of the sheet")->type_name("DIR")->group(group);
  command->add_option("--world-frames", request->world_frames, "Of the floor")->type_name("DIR")->group(group);
  command->add_option("--robots-frames", request->robots_frames, "Of the robots")->type_name("DIR")->group(group);
  command->footer(
      "Each step says what it does, shows the plain command that does the same, and can be repeated alone. A\n"
      "configuration that is there is kept; a calibration that somebody edited is, too.\n\n"
      "  chequer start\n"
      "The lens once more, after it was refocused:\n"
      "  chequer start lens --name north --folder /etc/chequer");
  command->callback([request] { RunStart(*request); });
}

}  // namespace chequer
