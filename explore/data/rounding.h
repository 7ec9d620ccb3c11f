// Steps in which an instrument or a file rounds its readings, as the readings themselves show them.
#pragma once

#include <vector>

namespace explore::data {

// The largest step of which all values are multiples: 1, 2, 2.5 or 5 times a power of ten, of the unit or of 25.4 times
// it (mils and inches in mm); 0: there are too few values to tell, or none is as large as the digits that they have in
// common by chance. Rounding to a step q has the variance q^2 / 12 where values are spread over several steps.
double rounding_step(const std::vector<double>& values);

} // namespace explore::data
