module bw_sensor_lines
  !! Input and output of the measurement of waves: lines at sensors of known positions, and the waves of each line.
  use bw_constants, only: two_pi
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_piece_beam, only: piece_beam
  use bw_text, only: shortest, string
  implicit none (type, external)
  private
  public :: hertz, square_of


  type, public :: sensor_facts
    !! What is known besides the lines.
    real(dp), allocatable :: position(:)       !! ξ of the sensors, (S)
    type(string), allocatable :: quantity(:)   !! displacement, velocity, acceleration or strain, (S)
    real(dp) :: length = 0                     !! of the beam, m; 0: not known
    character(:), allocatable :: ends          !! 'model', 'tip', 'clamped' or 'any'
    type(piece_beam) :: model                  !! with 'model': the beam with its supports and attached bodies
    logical :: simulated = .false.             !! simulated histories, whose ends are exactly as given
    logical :: rotates = .false.               !! in the plane of bending, so that ω enters the dispersion
    real(dp) :: stiffness_root = 0             !! √(EI/ρA) of the scene, to compare the waves with, m²/s; 0: not known
    real(dp) :: angular_velocity = 0           !! ω of the scene, rad/s
    real(dp) :: confidence = 0.95_dp           !! of the intervals
    integer :: alone = 0                       !! with 'tip', the mode number of a single line; 0: not known
  end type sensor_facts

  type, public :: measured_lines
    !! Lines common to all sensors.
    real(dp), allocatable :: angular_frequency(:), frequency_deviation(:)  !! rad/s, > 0, and its standard deviation, (line)
    real(dp), allocatable :: decay_rate(:)     !! of e^(−δt), 1/s, (line)
    complex(dp), allocatable :: amplitude(:, :)  !! of e^(iβt), (S, line)
    real(dp), allocatable :: deviation(:, :)   !! standard deviation of real and of imaginary part at known frequency and decay;
                                               !! 0 at all sensors of a line: not known, (S, line)
    complex(dp), allocatable :: correlation(:, :, :)  !! of these errors; allocated if sensors share noise, (S, S, line)
  end type measured_lines

  type, public :: sensor_waves
    !! Waves of the lines. Values that do not exist are `missing`; errors are half-widths of intervals.
    real(dp), allocatable :: wavenumber(:), wavenumber_error(:)          !! 1/m, (line)
    real(dp), allocatable :: phase_velocity(:), phase_velocity_error(:)  !! m/s
    real(dp), allocatable :: group_velocity(:), group_velocity_error(:)  !! m/s
    real(dp) :: stiffness_root = missing, stiffness_root_error = missing !! √(EI/ρA), m²/s
    real(dp) :: angular_velocity = missing, angular_velocity_error = missing  !! |ω|, rad/s
    type(string), allocatable :: notes(:)      !! reasons for missing values, and warnings
  end type sensor_waves

contains

  pure function hertz(lines, k) result(words)
    !! The frequency of a line as text.
    type(measured_lines), intent(in) :: lines
    integer, intent(in) :: k
    character(:), allocatable :: words
    words = shortest(lines%angular_frequency(k)/two_pi, 6)//' Hz'
  end function hertz

  pure function square_of(lines) result(square)
    !! Squares β² of the undamped angular frequencies of the lines.
    type(measured_lines), intent(in) :: lines
    real(dp) :: square(size(lines%angular_frequency))
    square = lines%angular_frequency**2 + lines%decay_rate**2
  end function square_of

end module bw_sensor_lines
