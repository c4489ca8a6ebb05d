module bw_noise_alone
  !! What a record costs without lines, as noise of any colour: the motion of a driven beam is that.
  use bw_cost, only: order_price
  use bw_kinds, only: dp
  use bw_samples, only: samples_type
  use bw_vector_noise, only: vector_noise_cost
  implicit none (type, external)
  private
  public :: cost_of_shared_motion, most_orders

  integer, parameter :: least_colour = 8          !! order in a record that is large

contains

  real(dp) function cost_of_shared_motion(samples) result(cost)
    !! J of noise alone that is one motion of all sensors; huge where samples are missing.
    type(samples_type), intent(in) :: samples
    real(dp), allocatable :: x(:, :)
    integer :: s, n
    cost = huge(1.0_dp)
    n = samples%count
    if (allocated(samples%valid) .or. size(samples%value, 2) == 1) return
    allocate (x(n, size(samples%value, 2)))
    do s = 1, size(x, 2)
      x(:, s) = samples%value(:n, s) - sum(samples%value(:n, s))/n
    end do
    cost = vector_noise_cost(x, most_orders(samples, n/(10*size(x, 2)), size(x, 2)), order_price(samples))
  end function cost_of_shared_motion

  pure integer function most_orders(samples, highest, sensors) result(order)
    !! As high an order of noise alone as takes a fraction of a second, each being predicted from so many sensors.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: highest, sensors
    real(dp), parameter :: products = 2.0e8_dp
    order = min(highest, max(least_colour, int(products/(real(size(samples%value), dp)*sensors))))
  end function most_orders

end module bw_noise_alone
