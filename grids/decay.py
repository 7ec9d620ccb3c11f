"""Two tanks that empty: what is left of both, seen together. Reads in.txt, writes out.csv."""
import math

fast, slow = (float(line) for line in open("in.txt"))
with open("out.csv", "w") as out:
    out.write("name,value\n")
    for second in range(1, 13):
        out.write(f"level after {second} s,{0.5 * (math.exp(-second / fast) + math.exp(-second / slow))!r}\n")
    out.write(f"time to a tenth,{max(fast, slow) * math.log(5.0)!r}\n")
