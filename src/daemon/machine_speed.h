#pragma once

namespace chequer {

/// Units of DetectStats::work that one thread of this machine does in a second while so many work at once, measured on a
/// frame of blurred boards that is the same everywhere: the slowest of them, as they share memory and, mostly, cores.
/// Takes some 80 ms, in an emulated machine seconds, and logs the result. @throws std::system_error where threads cannot
/// be started.
double MeasureSpeed(int workers);

}  // namespace chequer
