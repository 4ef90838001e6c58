#pragma once

namespace chequer {

/// Units of DetectStats::work that one thread of this machine does in a second, measured on a frame of blurred boards that
/// is the same everywhere. The fastest of a few runs: what else the machine does at that moment counts little. Takes some
/// 60 ms and logs the result.
double MeasureSpeed();

}  // namespace chequer
