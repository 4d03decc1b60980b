// The mesh of disc_brake.hvi: gmsh -3 -format msh41 -bin disc_brake.geo
// Two segments of rings on each other, in mm: the rotor, below y = 0, and the lining, above it. Layers are thin where they rub.
// The rotor is a micrometre lower: gmsh makes one surface of two that touch.
inner = 90; outer = 130; angle = 40*Pi/180; apart = 0.001;
// A sector: numbers of its first point and line, height, cells along and across it.
Macro Sector
  Point(p)     = {inner*Cos(-angle/2), y, inner*Sin(-angle/2)};
  Point(p + 1) = {outer*Cos(-angle/2), y, outer*Sin(-angle/2)};
  Point(p + 2) = {outer*Cos(angle/2), y, outer*Sin(angle/2)};
  Point(p + 3) = {inner*Cos(angle/2), y, inner*Sin(angle/2)};
  Point(p + 4) = {0, y, 0};
  Line(p)       = {p, p + 1};
  Circle(p + 1) = {p + 1, p + 4, p + 2};
  Line(p + 2)   = {p + 2, p + 3};
  Circle(p + 3) = {p + 3, p + 4, p};
  Curve Loop(p) = {p, p + 1, p + 2, p + 3};
  Plane Surface(p) = {p};
  Transfinite Curve {p, p + 2} = across + 1;
  Transfinite Curve {p + 1, p + 3} = along + 1;
  Transfinite Surface {p} Alternated;
Return
along = 10;
p = 10; y = -apart; across = 5;
Call Sector;
p = 20; y = 0; across = 4;
Call Sector;
rotor[]  = Extrude {0, -10, 0} { Surface{10}; Layers{ {1, 1, 1, 1, 1, 1}, {0.04, 0.11, 0.22, 0.4, 0.66, 1} }; };
lining[] = Extrude {0, 8, 0} { Surface{20}; Layers{ {1, 1, 1, 1, 1, 1, 1, 1}, {0.015, 0.045, 0.09, 0.15, 0.23, 0.34, 0.52, 1} }; };
Physical Surface("top")   = {10};
Physical Surface("hub")   = {rotor[0]};
Physical Surface("foot")  = {20};
Physical Surface("back")  = {lining[0]};
Physical Volume("rotor")  = {rotor[1]};
Physical Volume("lining") = {lining[1]};
