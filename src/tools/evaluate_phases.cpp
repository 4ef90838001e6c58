#include "tools/evaluate_phases.h"

#include <cstdio>
#include <stdexcept>

#include "core/file.h"
#include "tools/phase_figure.h"
#include "tools/phase_report.h"

namespace chequer {

void EvaluatePhases(const EvaluatePhasesRequest& request) {
  for (std::size_t i = 0; i < request.files.size(); ++i) {
    const PhaseRun run = ReadPhaseRun(request.files[i], request.truth, request.channel);
    const std::string text = request.json ? PhasesJson(run) : (i > 0 ? "\n" : "") + DescribePhases(run);
    std::fwrite(text.data(), 1, text.size(), stdout);
    if (request.figures.empty()) continue;
    const std::string number = request.files.size() > 1 ? std::to_string(i + 1) : "";
    WriteFileAtomically(request.figures + "phases" + number + ".png", DrawPhaseFigure(run));
  }
  if (std::fflush(stdout) != 0) throw std::runtime_error("standard output could not be written to the end");
}

}  // namespace chequer
