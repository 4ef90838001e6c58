#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/file.h"
#include "tools/commands.h"
#include "tools/evaluate_phases.h"
#include "tools/evaluation.h"
#include "tools/number_check.h"
#include "tools/run_file.h"
#include "tools/track_figure.h"

namespace chequer {
namespace {

/// The options as typed.
struct EvaluateRequest {
  std::vector<std::string> files;
  std::optional<std::uint64_t> id;
  std::string channel;
  std::string figures;
  bool json = false;
  bool phases = false;
  std::string truth;
};

void RunPhases(const EvaluateRequest& request) {
  if (request.truth.empty())
    throw CLI::ValidationError("--truth", "is missing: --phases needs the recording that `chequer render` made");
  if (request.id) throw CLI::ValidationError("--id", "does not go with --phases, which counts all markers");
  EvaluatePhases({request.files, request.truth, request.channel, request.figures, request.json});
}

void WriteFigures(const std::string& prefix, const std::vector<Evaluation>& runs) {
  bool any = false;
  for (const Evaluation& run : runs) any |= run.track.has_value();
  if (!any) throw std::runtime_error("there is nothing to draw: no run has three poses along a straight track");
  for (const TrackFigure figure : {TrackFigure::kLinear, TrackFigure::kAngular})
    WriteFileAtomically(prefix + std::to_string(static_cast<int>(figure)) + ".svg", DrawTrackFigure(figure, runs));
}

void RunEvaluate(const EvaluateRequest& request) {
  std::vector<Evaluation> runs;
  for (const std::string& file : request.files) runs.push_back(Evaluate(ReadRun(file, request.channel), request.id));
  for (const Evaluation& run : runs) {
    const std::string text = request.json ? JsonLine(run) + "\n" : Describe(run);
    std::fwrite(text.data(), 1, text.size(), stdout);
  }
  if (std::fflush(stdout) != 0) throw std::runtime_error("standard output could not be written to the end");
  if (!request.figures.empty()) WriteFigures(request.figures, runs);
}

}  // namespace

void AddEvaluateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("evaluate", "Measures how exact a run along a straight track is");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<EvaluateRequest>();
  command->add_option("FILE", request->files, "Runs: what `chequer detect --json` printed, or logs of lcm-logger")
      ->required();
  command->add_option("--id", request->id, "The marker's id; without it, the one that was read most often")
      ->check(IsWhole())
      ->type_name("N");
  command->add_option("--channel", request->channel, "Of a log that holds the poses of several cameras")
      ->type_name("NAME");
  command
      ->add_option("--figures", request->figures,
                   "Draw the errors as PREFIX10.svg and PREFIX11.svg; with --phases, the run as PREFIXphases.png")
      ->type_name("PREFIX");
  command->add_flag("--json", request->json, "One JSON object a line and run; with --phases, a line and phase");
  CLI::Option* phases =
      command->add_flag("--phases", request->phases, "Runs over a rendered stream: how each phase of it went");
  command->add_option("--truth", request->truth, "The stream's recording, as `chequer render --scenario` made it")
      ->type_name("DIR")
      ->needs(phases);
  command->footer(
      "For runs of one marker that is moved along a straight track without turning; of others it says so.\n"
      "Such moves need no surveyed truth: errors are distances from the line, and angles to the\n"
      "orientation, that fit the run best. RMSE is the root of the mean square, MAE the mean; sqrt(SSE)/n takes the\n"
      "mean outside the root. The recognition rate is the share of frames in which the id was read.\n\n"
      "Two runs of one marker, before and after the lens was refocused:\n"
      "  chequer detect --calibration camera.toml --marker 6x6:secded:0.12 --json near/ > near.jsonl\n"
      "  chequer detect --calibration camera.toml --marker 6x6:secded:0.12 --json far/ > far.jsonl\n"
      "  chequer evaluate near.jsonl far.jsonl --figures track-\n"
      "What a service saw:\n"
      "  lcm-logger run.lcm    # and later\n"
      "  chequer evaluate run.lcm\n\n"
      "With --phases, markers are compared with the truth of a rendered stream. Recall counts boards of which at "
      "least\n"
      "half lies in the image, whole those that are seen from rim to rim. carried: of those read, with an id of earlier\n"
      "frames (id_carried), whose errors are in the JSON alone. wrong: an id read on another board; twice: on its own\n"
      "board once more; ghosts: where no board is. Squared errors over covariance are 1 on average where\n"
      "the covariance is right.\n"
      "  chequer render --scenario reference.toml --out stream\n"
      "  chequer detect --calibration stream/camera.toml --marker 6x6:secded:0.1 --json stream > stream.jsonl\n"
      "  chequer evaluate --phases stream.jsonl --truth stream --figures stream-");
  command->callback([request] { request->phases ? RunPhases(*request) : RunEvaluate(*request); });
}

}  // namespace chequer
