#pragma once

#include <string>
#include <vector>

namespace chequer {

/// What `chequer evaluate --phases` is asked for.
struct EvaluatePhasesRequest {
  std::vector<std::string> files;  ///< results
  std::string truth;               ///< folder of the recording
  std::string channel;
  std::string figures;  ///< prefix of the pictures; may be empty
  bool json = false;
};

/// Prints how runs over a stream fared, phase by phase, and draws them. Throws std::runtime_error naming the file and
/// what is wrong.
void EvaluatePhases(const EvaluatePhasesRequest& request);

}  // namespace chequer
