module bw_remainder
  !! What lines, offset and slope leave of a record, one sensor after the other.
  !!
  !! All sensors share decays and frequencies. Of even samples each line is tabulated once for all of them: over one block of samples,
  !! and where each block starts. A sensor's amplitudes turn that into the product of two small matrices, and no error builds up
  !! along the record. Lines that drift, and uneven samples, are taken out one by one.
  use bw_damped_line, only: add_uneven, damped_line, subtract_lines
  use bw_kinds, only: dp
  use bw_lapack, only: dgemm
  use bw_samples, only: centre_of, phase_factor, samples_type
  implicit none (type, external)
  private
  public :: find_remainder, tabulated

  integer, parameter :: block = 256              !! samples

  type, public :: motion_type
    !! Lines with tables of those that are taken out by tables.
    real(dp), allocatable :: still(:, :)         !! offset and slope over half the record, about its middle, (2, S)
    type(damped_line), allocatable :: steady(:)  !! lines of the tables
    type(damped_line), allocatable :: others(:)
    real(dp), allocatable :: tone(:, :)          !! real part and minus the imaginary part of e^(−dl + 2πifl), (block, 2 steady)
    complex(dp), allocatable :: turn(:, :)       !! e^(−dn + 2πifn) where a block starts, (steady, blocks)
  end type motion_type

contains

  pure function tabulated(samples, lines, still) result(motion)
    !! Prepare lines to be taken out of each sensor.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    type(motion_type) :: motion
    logical :: in_tables(size(lines))
    integer :: k, b, l
    in_tables = lines%powers == 1 .and. .not. allocated(samples%place)
    motion%still = still
    motion%steady = pack(lines, in_tables)
    motion%others = pack(lines, .not. in_tables)
    allocate (motion%tone(block, 2*size(motion%steady)), motion%turn(size(motion%steady), (samples%count + block - 1)/block))
    do k = 1, size(motion%steady)
      associate (line => motion%steady(k), last => max(samples%count - 1, 1))
        do l = 0, min(block, samples%count) - 1
          associate (tone => exp(-line%decay*l)*phase_factor(line%frequency, l, line%rest))
            motion%tone(l + 1, 2*k - 1) = real(tone, dp)
            motion%tone(l + 1, 2*k) = -aimag(tone)
          end associate
        end do
        do b = 1, size(motion%turn, 2)
          motion%turn(k, b) = exp(min(line%decay, 0.0_dp)*last - line%decay*((b - 1)*block))* &
            & phase_factor(line%frequency, (b - 1)*block, line%rest)
        end do
      end associate
    end do
  end function tabulated

  pure subroutine find_remainder(samples, motion, s, left)
    !! Find what is left of sensor s, (N). Memory that is there is used again.
    type(samples_type), intent(in) :: samples
    type(motion_type), intent(in) :: motion      !! as `tabulated` made it of these samples
    integer, intent(in) :: s
    real(dp), allocatable, intent(inout) :: left(:)
    real(dp), allocatable :: uneven(:, :)
    real(dp) :: centre, offset, slope
    integer :: n
    if (allocated(left)) then
      if (size(left) /= samples%count) deallocate (left)
    end if
    if (.not. allocated(left)) allocate (left(samples%count))
    centre = centre_of(samples)
    if (allocated(samples%place)) then
      uneven = reshape(samples%value(:samples%count, s) - motion%still(1, s) &
        & - motion%still(2, s)*(samples%place(:samples%count)/centre - 1), [samples%count, 1])
      call add_uneven(samples, motion%others, s, -1.0_dp, uneven)
      left = uneven(:, 1)
    else
      slope = motion%still(2, s)/centre
      offset = motion%still(1, s) - motion%still(2, s)
      do n = 1, samples%count
        left(n) = samples%value(n, s) - offset - slope*(n - 1)
      end do
      call take_out_steady(motion, s, left)
      call subtract_lines(motion%others, s, left)
    end if
  end subroutine find_remainder

  pure subroutine take_out_steady(motion, s, left)
    !! Take the lines of the tables out of a sensor.
    type(motion_type), intent(in) :: motion
    integer, intent(in) :: s
    real(dp), contiguous, intent(inout) :: left(:)
    real(dp) :: coefficient(size(motion%tone, 2), size(motion%turn, 2))
    integer :: b, k, whole, rest
    if (size(coefficient) == 0) return
    do b = 1, size(motion%turn, 2)
      do k = 1, size(motion%steady)
        associate (now => motion%steady(k)%amplitude(s)*motion%turn(k, b))
          coefficient(2*k - 1, b) = real(now, dp)
          coefficient(2*k, b) = aimag(now)
        end associate
      end do
    end do
    whole = size(left)/block
    rest = size(left) - whole*block
    associate (terms => size(coefficient, 1))
      if (whole > 0) call dgemm('N', 'N', block, whole, terms, -1.0_dp, motion%tone, block, coefficient, terms, 1.0_dp, left, block)
      if (rest > 0) call dgemm('N', 'N', rest, 1, terms, -1.0_dp, motion%tone, block, coefficient(:, whole + 1:), terms, 1.0_dp, &
        & left(whole*block + 1:), rest)
    end associate
  end subroutine take_out_steady

end module bw_remainder
