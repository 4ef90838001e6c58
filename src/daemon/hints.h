#pragma once

#include <vector>

#include "chequer/detector.h"
#include "daemon/frame_look.h"
#include "marker/variant_guess.h"
#include "publish/messages.h"

namespace chequer {

/// What single frames show of why markers are not read, as named counts of status_t. One thread.
class Hints {
 public:
  explicit Hints(const std::vector<MarkerFamily>& families);

  void Take(const FrameLook& look);

  /// Of what was taken since the last call, those that apply: how many frames or boards show each. Their names begin
  /// with kHintPrefix; lcmtypes/status_t.lcm says what each means.
  std::vector<NamedCount> TakeCounts();

 private:
  struct Family {
    MarkerFamily sought;
    VariantGuess guess;
  };
  void TakePicture(const FrameLook& look);
  void Count(std::string_view name, std::uint64_t more = 1);

  std::vector<Family> families_;
  std::vector<NamedCount> counts_;
  int looks_ = 0;
};

}  // namespace chequer
