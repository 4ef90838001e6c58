#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "publish/messages.h"
#include "simulate/truth.h"

namespace chequer::test {

/// The truth of a recording that a camera shows over and over, so that nobody knows which of its frames a message is
/// of.
class SwarmTruth {
 public:
  /// Throws std::runtime_error where the recording has no truth.
  explicit SwarmTruth(const std::filesystem::path& recording);

  /// Empty if a message is right: every marker of one of the frames was found, no other, each within a hundredth of its
  /// distance. Else what is wrong with it.
  std::string Judge(const PosesMessage& message) const;

 private:
  std::vector<FrameTruth> frames_;
};

}  // namespace chequer::test
