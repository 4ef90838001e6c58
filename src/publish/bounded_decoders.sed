# The decoders that lcm-gen writes make room for as many elements as a message says it has: a few bytes from the network
# could ask for all memory there is. Before each such place a line refuses more than the message has bytes for: elements
# that are types, then those that are numbers.
s/^    this->([a-z_]+)\.resize\(this->([a-z_]+)\);/    if(this->\2 < 0 || this->\2 > (maxlen - pos) \/ decltype(this->\1)::value_type()._getEncodedSizeNoHash()) return -1;\n&/
s/^        this->([a-z_]+)\.resize\(this->([a-z_]+)\);/        if(this->\2 < 0 || this->\2 > (maxlen - pos) \/ static_cast<int>(sizeof(decltype(this->\1)::value_type))) return -1;\n&/
# Texts have at least their zero byte; a length below that is not looked for either.
s/if\((__[a-z_]+_len__) > maxlen - pos\) return -1;/if(\1 < 1 || \1 > maxlen - pos) return -1;/
